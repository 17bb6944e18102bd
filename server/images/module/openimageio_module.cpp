// heliograph-images.so: the only file that sees OpenImageIO. It is a library of its own, which the program loads when it needs
// it (server/images/image_module.h).

#include "server/images/image_module.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <stdexcept>

namespace heliograph {

namespace {

/// No exception leaves the module; `message` gets its first line.
template <typename Work>
int guarded(char* message, const Work& work) {
    try {
        work();
        return 1;
    } catch (const std::exception& error) {
        const std::string_view text = error.what();
        const size_t length = std::min({text.find('\n'), text.size(), IMAGE_MESSAGE_BYTES - 1});
        std::copy_n(text.data(), length, message);
        message[length] = 0;
        return 0;
    }
}

/// An opened picture with the memory that it reads from.
struct OpenedImage {
    OIIO::Filesystem::IOMemReader memory;
    std::unique_ptr<OIIO::ImageInput> input;
    ImageHeader header{};

    explicit OpenedImage(const ImageFile& file) : memory(const_cast<uint8_t*>(file.bytes), file.size) {
        input = OIIO::ImageInput::create(file.reader);
        if (!input) throw std::runtime_error(OIIO::geterror());
        if (!input->set_ioproxy(&memory)) throw std::runtime_error("this OpenImageIO cannot read the format from memory");
        OIIO::ImageSpec config, spec;
        config.attribute("oiio:UnassociatedAlpha", 1);
        if (!input->open(std::string("memory.") + file.reader, spec, config)) throw std::runtime_error(input->geterror());
        header = {spec.width, spec.height, spec.nchannels, spec.depth <= 1 && !spec.deep};
    }
};

int readHeader(const ImageFile* file, ImageHeader* header, char* message) {
    return guarded(message, [&] { *header = OpenedImage(*file).header; });
}

int readPixels(const ImageFile* file, const ImageHeader* header, int32_t channels, float* pixels, char* message) {
    return guarded(message, [&] {
        OpenedImage opened(*file);
        const ImageHeader& now = opened.header;
        if (now.width != header->width || now.height != header->height || now.channels < channels || !now.flat)
            throw std::runtime_error("its header is another one now");
        if (!opened.input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, pixels))
            throw std::runtime_error(opened.input->geterror());
    });
}

int writeExr(const float* pixels, int32_t width, int32_t height, void (*take)(void*, const uint8_t*, size_t), void* to,
             char* message) {
    return guarded(message, [&] {
        auto output = OIIO::ImageOutput::create("film.exr");
        if (!output) throw std::runtime_error(OIIO::geterror());
        OIIO::Filesystem::IOVecOutput sink;
        if (!output->set_ioproxy(&sink)) throw std::runtime_error("OpenImageIO cannot write to memory");
        OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::FLOAT);
        spec.attribute("compression", "zip");
        spec.attribute("oiio:ColorSpace", "linear");
        spec.attribute("DateTime", "1970:01:01 00:00:00");  // the same picture is the same file; left out, it would be now
        constexpr OIIO::stride_t PIXEL = 4 * sizeof(float);
        if (!output->open("film.exr", spec) || !output->write_image(OIIO::TypeDesc::FLOAT, pixels, PIXEL, PIXEL * width) ||
            !output->close())
            throw std::runtime_error(output->geterror());
        take(to, sink.buffer().data(), sink.buffer().size());
    });
}

constexpr ImageModule MODULE{IMAGE_MODULE_VERSION, readHeader, readPixels, writeExr};

}  // namespace

}  // namespace heliograph

extern "C" __attribute__((visibility("default"))) const heliograph::ImageModule* heliographImageModule() {
    return &heliograph::MODULE;
}

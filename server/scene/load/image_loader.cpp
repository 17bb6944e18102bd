#include "server/scene/load/image_loader.h"

#include "server/base/error.h"
#include "server/scene/load/file_folder.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstring>

namespace heliograph {

namespace {

constexpr uint32_t LONGEST_SIDE = 16384;
constexpr uint64_t MOST_PIXELS = uint64_t(128) << 20;
constexpr uint64_t BUDGET_BASE = uint64_t(192) << 20;
constexpr uint64_t BUDGET_PER_BYTE = 100;

/// A format that we read: how its files begin and the name of OpenImageIO's reader.
struct Format {
    std::string_view magic;
    const char* reader;
    bool hdr;
};
constexpr Format FORMATS[] = {
    {"\x89PNG\r\n\x1a\n", "png", false},
    {"\xff\xd8\xff", "jpeg", false},
    {std::string_view("\x76\x2f\x31\x01", 4), "openexr", true},
    {"#?", "hdr", true},
};

/// By content, never by the file's name.
const Format* formatOf(std::span<const uint8_t> file) {
    const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
    for (const Format& format : FORMATS) {
        if (bytes.substr(0, format.magic.size()) == format.magic) return &format;
    }
    return nullptr;
}

/// An opened image with the memory that it reads from.
struct OpenedImage {
    OIIO::Filesystem::IOMemReader memory;
    std::unique_ptr<OIIO::ImageInput> input;
    ImageInfo info;

    /// `path`: the file that the bytes are from, for the readers that cannot read from memory; may be empty.
    OpenedImage(std::span<const uint8_t> file, const std::string& name, const std::string& path)
        : memory(const_cast<uint8_t*>(file.data()), file.size()) {
        const Format* format = formatOf(file);
        if (!format) throw InputError(name, "unknown image format", "PNG, JPEG, Radiance HDR or OpenEXR");
        input = OIIO::ImageInput::create(format->reader);
        if (!input) throw InputError(name, "the image cannot be read: " + firstLine(OIIO::geterror()));
        const bool fromMemory = input->set_ioproxy(&memory);
        if (!fromMemory && path.empty())
            throw InputError(name, "a Radiance HDR image inside another file", "PNG or JPEG");
        OIIO::ImageSpec config, spec;
        config.attribute("oiio:UnassociatedAlpha", 1);
        if (!input->open(fromMemory ? std::string("memory.") + format->reader : path, spec, config))
            throw InputError(name, "the image cannot be read: " + firstLine(input->geterror()));
        check(spec, name);
        info.width = static_cast<uint32_t>(spec.width);
        info.height = static_cast<uint32_t>(spec.height);
        info.channels = spec.nchannels;
        info.hdr = format->hdr;
    }

    static std::string firstLine(const std::string& text) {
        return text.substr(0, std::min(text.find('\n'), size_t(200)));
    }

    static void check(const OIIO::ImageSpec& spec, const std::string& name) {
        const std::string size = std::to_string(spec.width) + " x " + std::to_string(spec.height);
        if (spec.width < 1 || spec.height < 1 || spec.width > int(LONGEST_SIDE) || spec.height > int(LONGEST_SIDE) ||
            static_cast<uint64_t>(spec.width) * spec.height > MOST_PIXELS) {
            throw InputError(name, size + " pixels",
                             "sides of 1 to " + std::to_string(LONGEST_SIDE) + ", at most " +
                                 std::to_string(MOST_PIXELS) + " pixels");
        }
        if (spec.nchannels < 1 || spec.nchannels > 16 || spec.depth > 1 || spec.deep)
            throw InputError(name, "a deep image, a volume, or one of " + std::to_string(spec.nchannels) + " channels",
                             "a flat image of 1 to 16 channels");
    }

    template <typename T>
    void read(std::vector<T>& pixels, int channels, OIIO::TypeDesc type, const std::string& name) {
        pixels.resize(static_cast<size_t>(info.width) * info.height * channels);
        if (!input->read_image(0, 0, 0, channels, type, pixels.data()))
            throw InputError(name, "the pixels cannot be decoded: " + firstLine(input->geterror()));
    }
};

/// Spreads 1 (grey), 2 (grey, alpha) or 3 channels to RGBA in place.
void spreadToRgba(std::vector<uint8_t>& pixels, size_t texels, int channels) {
    if (channels == 4) return;
    pixels.resize(texels * 4);
    for (size_t i = texels; i-- > 0;) {  // from the end: the target never overtakes its source
        const uint8_t* from = &pixels[i * channels];
        const uint8_t r = from[0];
        const uint8_t g = channels == 3 ? from[1] : r;
        const uint8_t b = channels == 3 ? from[2] : r;
        const uint8_t a = channels == 2 ? from[1] : 255;
        uint8_t* to = &pixels[i * 4];
        to[0] = r;
        to[1] = g;
        to[2] = b;
        to[3] = a;
    }
}

void spreadToRgb(std::vector<float>& pixels, size_t texels, int channels) {
    if (channels == 3) return;
    pixels.resize(texels * 3);
    for (size_t i = texels; i-- > 0;) {
        const float grey = pixels[i];
        for (int c = 0; c < 3; c++) pixels[i * 3 + c] = grey;
    }
}

/// Reads all pixels; `path` as for OpenedImage.
ImageData decode(std::span<const uint8_t> file, const std::string& name, const std::string& path, bool srgb) {
    OpenedImage opened(file, name, path);
    ImageData image;
    image.width = opened.info.width;
    image.height = opened.info.height;
    image.srgb = srgb;
    image.name = name;
    const size_t texels = static_cast<size_t>(image.width) * image.height;
    const int channels = opened.info.channels;
    if (opened.info.hdr) {
        const int read = channels >= 3 ? 3 : 1;
        opened.read(image.rgb32f, read, OIIO::TypeDesc::FLOAT, name);
        spreadToRgb(image.rgb32f, texels, read);
    } else {
        const int read = std::min(channels, 4);
        opened.read(image.rgba8, read, OIIO::TypeDesc::UINT8, name);
        spreadToRgba(image.rgba8, texels, read);
    }
    return image;
}

}  // namespace

ImageInfo inspectImage(std::span<const uint8_t> file, const std::string& name) {
    return OpenedImage(file, name, {}).info;
}

ImageData decodeImage(std::span<const uint8_t> file, const std::string& name, bool srgb) {
    return decode(file, name, {}, srgb);
}

ImageData loadImage(const std::filesystem::path& path, bool srgb) {
    const std::vector<uint8_t> file = readFile(path);
    return decode(file, path.string(), path.string(), srgb);
}

void ImageBudget::take(const std::string& name, uint64_t fileBytes, uint64_t decodedBytes) {
    fileBytes_ += fileBytes;
    decodedBytes_ += decodedBytes;
    const uint64_t most = BUDGET_BASE + BUDGET_PER_BYTE * fileBytes_;
    if (decodedBytes_ > most) {
        throw InputError(name, "the images decode to " + std::to_string(decodedBytes_) + " bytes",
                         "at most " + std::to_string(most) + " for files of " + std::to_string(fileBytes_) + " bytes");
    }
}

}  // namespace heliograph

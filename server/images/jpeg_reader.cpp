#include "server/images/picture_reader.h"

#include <turbojpeg.h>

#include <memory>
#include <stdexcept>

namespace heliograph {

namespace {

using Decoder = std::unique_ptr<void, int (*)(tjhandle)>;

struct OpenedJpeg {
    Decoder decoder{tjInitDecompress(), tjDestroy};
    PictureSize size;
    bool inks = false;

    explicit OpenedJpeg(std::span<const uint8_t> file) {
        if (!decoder) throw std::runtime_error("libjpeg-turbo could not be started");
        int width = 0, height = 0, sampling = 0, space = 0;
        // Fails also, with the size known, for a sampling without a name of its own, which can be decoded all the same.
        const int failed = tjDecompressHeader3(decoder.get(), file.data(), file.size(), &width, &height, &sampling, &space);
        if (failed && (width < 1 || height < 1)) throw std::runtime_error(tjGetErrorStr2(decoder.get()));
        size = {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
        inks = space == TJCS_CMYK || space == TJCS_YCCK;
    }
};

/// Four inks, stored as 255 - ink, to the light that they leave, in place.
void lightOfInks(std::span<uint8_t> pixels) {
    for (size_t i = 0; i + 3 < pixels.size(); i += 4) {
        const uint32_t black = pixels[i + 3];
        for (size_t c = 0; c < 3; c++) pixels[i + c] = static_cast<uint8_t>((pixels[i + c] * black + 127) / 255);
        pixels[i + 3] = 255;
    }
}

}  // namespace

PictureSize readJpegSize(std::span<const uint8_t> file) { return OpenedJpeg(file).size; }

void readJpeg(std::span<const uint8_t> file, std::span<uint8_t> rgba) {
    const OpenedJpeg jpeg(file);
    if (rgba.size() != size_t(4) * jpeg.size.width * jpeg.size.height)
        throw std::runtime_error("not the size that its header says");
    // Hundreds of scans over a large picture are a small file that takes minutes.
    const int failed =
        tjDecompress2(jpeg.decoder.get(), file.data(), file.size(), rgba.data(), static_cast<int>(jpeg.size.width), 0,
                      static_cast<int>(jpeg.size.height), jpeg.inks ? TJPF_CMYK : TJPF_RGBA, TJFLAG_LIMITSCANS);
    if (failed && tjGetErrorCode(jpeg.decoder.get()) != TJERR_WARNING)
        throw std::runtime_error(tjGetErrorStr2(jpeg.decoder.get()));
    if (jpeg.inks) lightOfInks(rgba);
}

}  // namespace heliograph

#include "server/encode/png_encoder.h"

#include <png.h>

#include <stdexcept>

namespace heliograph {

namespace {

void appendTo(png_structp png, png_bytep data, size_t size) {
    auto* bytes = static_cast<std::vector<uint8_t>*>(png_get_io_ptr(png));
    bytes->insert(bytes->end(), data, data + size);
}

void flushNothing(png_structp) {}

/// libpng's C code is left by an exception: Debian builds it with unwind tables, and nothing of it needs cleaning up but
/// what WriteState destroys.
[[noreturn]] void fail(png_structp, png_const_charp message) { throw std::runtime_error(std::string("png: ") + message); }

void ignoreWarning(png_structp, png_const_charp) {}

struct WriteState {
    png_structp png = nullptr;
    png_infop info = nullptr;

    WriteState() {
        png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignoreWarning);
        if (png == nullptr) throw std::runtime_error("png: the library could not be started");
        info = png_create_info_struct(png);
    }
    ~WriteState() { png_destroy_write_struct(&png, &info); }
    WriteState(const WriteState&) = delete;
};

class PngEncoder : public Encoder {
public:
    std::string mimeType() const override { return "image/png"; }

    /// `quality` has no meaning here.
    double encode(const DisplayImage& image, uint32_t, std::vector<uint8_t>& bytes) override {
        bytes.clear();
        WriteState state;
        png_set_write_fn(state.png, &bytes, appendTo, flushNothing);
        png_set_user_limits(state.png, 0x7fffffff, 0x7fffffff);
        png_set_IHDR(state.png, state.info, image.width, image.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                     PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
        png_set_sRGB(state.png, state.info, PNG_sRGB_INTENT_PERCEPTUAL);
        // Fixed filter and level: rendered pictures are noisy, where trying all filters costs three times as much time for
        // a few percent.
        png_set_filter(state.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_PAETH);
        png_set_compression_level(state.png, 4);
        png_write_info(state.png, state.info);
        png_set_filler(state.png, 0, PNG_FILLER_AFTER);  // drops the alpha of RGBA
        for (uint32_t y = 0; y < image.height; y++) {
            png_write_row(state.png, &image.rgba[static_cast<size_t>(y) * image.width * 4]);
        }
        png_write_end(state.png, nullptr);
        return 0.0;
    }
};

}  // namespace

std::unique_ptr<Encoder> makePngEncoder() { return std::make_unique<PngEncoder>(); }

}  // namespace heliograph

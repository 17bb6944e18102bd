#include "server/images/picture_reader.h"

#include <png.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace heliograph {

namespace {

/// libpng's C code is left by an exception, as in encode/png_encoder.cpp.
[[noreturn]] void fail(png_structp, png_const_charp message) { throw std::runtime_error(message); }
void ignoreWarning(png_structp, png_const_charp) {}

class PngReader {
public:
    explicit PngReader(std::span<const uint8_t> file) : rest_(file) {
        png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, ignoreWarning);
        if (!png_) throw std::runtime_error("libpng could not be started");
        try {
            info_ = png_create_info_struct(png_);
            png_set_read_fn(png_, this, take);
            png_read_info(png_, info_);
        } catch (...) {
            png_destroy_read_struct(&png_, &info_, nullptr);
            throw;
        }
    }
    ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
    PngReader(const PngReader&) = delete;

    PictureSize size() const { return {png_get_image_width(png_, info_), png_get_image_height(png_, info_)}; }

    void read(std::span<uint8_t> rgba) {
        png_set_expand(png_);
        png_set_scale_16(png_);
        png_set_gray_to_rgb(png_);
        png_set_add_alpha(png_, 255, PNG_FILLER_AFTER);
        const int passes = png_set_interlace_handling(png_);
        png_read_update_info(png_, info_);
        const size_t row = size_t(4) * size().width;
        if (png_get_rowbytes(png_, info_) != row || rgba.size() != row * size().height)
            throw std::runtime_error("not the size that its header says");
        for (int pass = 0; pass < passes; pass++) {
            for (size_t at = 0; at < rgba.size(); at += row) png_read_row(png_, &rgba[at], nullptr);
        }
    }

private:
    static void take(png_structp png, png_bytep to, size_t size) {
        auto& rest = static_cast<PngReader*>(png_get_io_ptr(png))->rest_;
        if (size > rest.size()) png_error(png, "the file ends too early");
        std::memcpy(to, rest.data(), size);
        rest = rest.subspan(size);
    }

    std::span<const uint8_t> rest_;
    png_structp png_ = nullptr;
    png_infop info_ = nullptr;
};

}  // namespace

PictureSize readPngSize(std::span<const uint8_t> file) { return PngReader(file).size(); }

void readPng(std::span<const uint8_t> file, std::span<uint8_t> rgba) { PngReader(file).read(rgba); }

}  // namespace heliograph

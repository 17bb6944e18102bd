#include "server/encode/jpeg_encoder.h"

#include <turbojpeg.h>

#include <algorithm>
#include <stdexcept>

namespace heliograph {

namespace {

constexpr uint32_t FULL_COLOUR_QUALITY = 90;

class JpegEncoder : public Encoder {
public:
    JpegEncoder() : compressor_(tjInitCompress()) {
        if (compressor_ == nullptr) throw std::runtime_error(std::string("jpeg: ") + tjGetErrorStr2(nullptr));
    }
    ~JpegEncoder() override { tjDestroy(compressor_); }
    JpegEncoder(const JpegEncoder&) = delete;

    std::string mimeType() const override { return "image/jpeg"; }

    void encode(const DisplayImage& image, uint32_t quality, std::vector<uint8_t>& bytes) override {
        const bool fine = quality >= FULL_COLOUR_QUALITY;
        const int sampling = fine ? TJSAMP_444 : TJSAMP_420;
        const auto width = static_cast<int>(image.width), height = static_cast<int>(image.height);
        unsigned long size = tjBufSize(width, height, sampling);
        if (size == static_cast<unsigned long>(-1)) throw std::runtime_error("jpeg: no pixels, or too many");
        // Large enough for the worst picture, and kept: growing a vector anew would clear megabytes for every frame.
        if (scratch_.size() < size) scratch_.resize(size);
        unsigned char* target = scratch_.data();
        const int flags = TJFLAG_NOREALLOC | (fine ? TJFLAG_ACCURATEDCT : TJFLAG_FASTDCT);
        const int level = static_cast<int>(std::clamp<uint32_t>(quality, 1, 100));
        if (tjCompress2(compressor_, image.rgba.data(), width, width * 4, height, TJPF_RGBX, &target, &size, sampling, level,
                        flags) != 0) {
            throw std::runtime_error(std::string("jpeg: ") + tjGetErrorStr2(compressor_));
        }
        bytes.assign(target, target + size);
    }

private:
    tjhandle compressor_;
    std::vector<unsigned char> scratch_;
};

}  // namespace

std::unique_ptr<Encoder> makeJpegEncoder() { return std::make_unique<JpegEncoder>(); }

}  // namespace heliograph

#include "server/encode/jpeg_encoder.h"

#include "server/encode/jpeg_stripes.h"

#include <turbojpeg.h>

#include <algorithm>
#include <stdexcept>

namespace heliograph {

namespace {

constexpr uint32_t FULL_COLOUR_QUALITY = 90;

/// One a thread: a compressor keeps its tables and buffers.
class Compressor {
public:
    Compressor() : handle_(tjInitCompress()) {
        if (handle_ == nullptr) throw std::runtime_error(std::string("jpeg: ") + tjGetErrorStr2(nullptr));
    }
    ~Compressor() { tjDestroy(handle_); }
    Compressor(const Compressor&) = delete;
    tjhandle get() const { return handle_; }

private:
    tjhandle handle_;
};

class JpegEncoder : public Encoder {
public:
    explicit JpegEncoder(StripeThreads threads) : threads_(threads) {}

    std::string mimeType() const override { return "image/jpeg"; }

    double encode(const DisplayImage& image, uint32_t quality, std::vector<uint8_t>& bytes) override {
        if (image.width == 0 || image.height == 0) throw std::runtime_error("jpeg: no pixels");
        const uint32_t count = (image.height + JPEG_STRIPE_ROWS - 1) / JPEG_STRIPE_ROWS;
        const bool fine = quality >= FULL_COLOUR_QUALITY;
        const uint32_t unit = fine ? 8 : 16;
        if (stripes_.size() < count) stripes_.resize(count);
        auto code = [&](uint32_t i) { encodeStripe(image, i * JPEG_STRIPE_ROWS, quality, fine, stripes_[i]); };
        const double others = forEachStripe(count, threads_, code);
        std::vector<std::span<const uint8_t>> files;
        for (uint32_t i = 0; i < count; i++) files.emplace_back(stripes_[i].bytes.data(), stripes_[i].size);
        bytes.clear();
        joinStripes(files, image.height, (image.width + unit - 1) / unit * (JPEG_STRIPE_ROWS / unit), bytes);
        return others;
    }

    void rest() override { stripes_ = {}; }

private:
    struct Stripe {
        std::vector<uint8_t> bytes;  // room for the worst, kept: growing it anew would clear megabytes for every frame
        unsigned long size = 0;
    };

    static void encodeStripe(const DisplayImage& image, uint32_t row, uint32_t quality, bool fine, Stripe& stripe) {
        thread_local const Compressor compressor;
        const int sampling = fine ? TJSAMP_444 : TJSAMP_420;
        const auto width = static_cast<int>(image.width);
        const auto rows = static_cast<int>(std::min(JPEG_STRIPE_ROWS, image.height - row));
        const size_t rowBytes = size_t{4} * image.width;
        stripe.size = tjBufSize(width, rows, sampling);
        if (stripe.size == static_cast<unsigned long>(-1)) throw std::runtime_error("jpeg: too many pixels");
        if (stripe.bytes.size() < stripe.size) stripe.bytes.resize(stripe.size);
        unsigned char* target = stripe.bytes.data();
        const int flags = TJFLAG_NOREALLOC | (fine ? TJFLAG_ACCURATEDCT : TJFLAG_FASTDCT);
        const int level = static_cast<int>(std::clamp<uint32_t>(quality, 1, 100));
        if (tjCompress2(compressor.get(), image.rgba.data() + row * rowBytes, width, static_cast<int>(rowBytes), rows,
                        TJPF_RGBX, &target, &stripe.size, sampling, level, flags) != 0) {
            throw std::runtime_error(std::string("jpeg: ") + tjGetErrorStr2(compressor.get()));
        }
    }

    StripeThreads threads_;
    std::vector<Stripe> stripes_;
};

}  // namespace

std::unique_ptr<Encoder> makeJpegEncoder(StripeThreads threads) { return std::make_unique<JpegEncoder>(threads); }

}  // namespace heliograph

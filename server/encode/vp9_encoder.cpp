#include "server/encode/vp9_encoder.h"

#include "server/encode/yuv.h"

#include <vpx/vp8cx.h>
#include <vpx/vpx_encoder.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace heliograph {

namespace {

constexpr int SPEED = 9;  // the fastest
constexpr unsigned int NO_LIMIT_KBIT = 1'000'000;
constexpr uint32_t LARGEST_SIDE = 16384;

/// Tables of libvpx and its state for pictures of one size.
class Vp9Context {
public:
    Vp9Context(uint32_t width, uint32_t height, uint32_t quantizer) {
        check(vpx_codec_enc_config_default(vpx_codec_vp9_cx(), &config_, 0), "configuration");
        config_.g_w = width;
        config_.g_h = height;
        config_.g_threads = 1;
        config_.g_timebase = {1, 30};  // nobody reads it: the quantizer rules, not a bit rate
        config_.g_lag_in_frames = 0;   // one in, one out
        config_.kf_mode = VPX_KF_DISABLED;
        config_.rc_end_usage = VPX_CBR;
        config_.rc_target_bitrate = NO_LIMIT_KBIT;
        config_.rc_dropframe_thresh = 0;
        config_.rc_resize_allowed = 0;
        config_.rc_min_quantizer = config_.rc_max_quantizer = quantizer;
        check(vpx_codec_enc_init(&codec_, vpx_codec_vp9_cx(), &config_, 0), "encoder");
        try {
            set(VP8E_SET_CPUUSED, SPEED);
            set(VP9E_SET_AQ_MODE, 0);
            set(VP8E_SET_ENABLEAUTOALTREF, 0);
            set(VP9E_SET_COLOR_SPACE, VPX_CS_BT_709);
            set(VP9E_SET_COLOR_RANGE, VPX_CR_STUDIO_RANGE);
        } catch (...) {
            vpx_codec_destroy(&codec_);
            throw;
        }
    }
    ~Vp9Context() { vpx_codec_destroy(&codec_); }
    Vp9Context(const Vp9Context&) = delete;

    bool fits(uint32_t width, uint32_t height) const { return config_.g_w == width && config_.g_h == height; }

    void setQuantizer(uint32_t quantizer) {
        if (config_.rc_max_quantizer == quantizer) return;
        config_.rc_min_quantizer = config_.rc_max_quantizer = quantizer;
        check(vpx_codec_enc_config_set(&codec_, &config_), "quantizer");
    }

    /// Returns whether it became a key picture.
    bool encode(const YuvImage& yuv, bool key, std::vector<uint8_t>& bytes) {
        vpx_image_t image;
        if (!vpx_img_wrap(&image, VPX_IMG_FMT_I420, yuv.width, yuv.height, 1, const_cast<uint8_t*>(yuv.y.data())))
            throw std::runtime_error("vp9: no picture of " + std::to_string(yuv.width) + " x " + std::to_string(yuv.height));
        const std::array<const std::vector<uint8_t>*, 3> planes = {&yuv.y, &yuv.u, &yuv.v};
        for (size_t i = 0; i < planes.size(); i++) {
            image.planes[i] = const_cast<uint8_t*>(planes[i]->data());  // libvpx reads them
            image.stride[i] = static_cast<int>(i == 0 ? yuv.width : yuv.colourWidth());
        }
        image.cs = VPX_CS_BT_709;
        check(vpx_codec_encode(&codec_, &image, time_++, 1, key ? VPX_EFLAG_FORCE_KF : 0, VPX_DL_REALTIME), "picture");
        bytes.clear();
        bool isKey = false;
        vpx_codec_iter_t at = nullptr;
        while (const vpx_codec_cx_pkt_t* packet = vpx_codec_get_cx_data(&codec_, &at)) {
            if (packet->kind != VPX_CODEC_CX_FRAME_PKT) continue;
            const auto* data = static_cast<const uint8_t*>(packet->data.frame.buf);
            bytes.insert(bytes.end(), data, data + packet->data.frame.sz);
            isKey = isKey || (packet->data.frame.flags & VPX_FRAME_IS_KEY) != 0;
        }
        if (bytes.empty()) throw std::runtime_error("vp9: the encoder gave nothing for a picture");
        return isKey;
    }

private:
    void set(vp8e_enc_control_id control, int value) { check(vpx_codec_control_(&codec_, control, value), "setting"); }
    void check(vpx_codec_err_t error, const char* what) {
        if (error != VPX_CODEC_OK)
            throw std::runtime_error(std::string("vp9: ") + what + ": " + vpx_codec_err_to_string(error));
    }

    vpx_codec_enc_cfg_t config_{};
    vpx_codec_ctx_t codec_{};
    vpx_codec_pts_t time_ = 0;
};

class Vp9Encoder : public VideoEncoder {
public:
    std::string mimeType() const override { return "video/vp9"; }
    void wantKey() override { wantsKey_ = true; }
    bool key() const override { return key_; }

    double encode(const DisplayImage& image, uint32_t quality, std::vector<uint8_t>& bytes) override {
        if (image.width == 0 || image.height == 0) throw std::runtime_error("vp9: no pixels");
        if (!vp9Fits(image.width, image.height)) throw std::runtime_error("vp9: too many pixels");
        const uint32_t quantizer = vp9Quantizer(quality);
        if (context_ && !context_->fits(image.width, image.height)) context_.reset();
        if (!context_) context_ = std::make_unique<Vp9Context>(image.width, image.height, quantizer);
        context_->setQuantizer(quantizer);
        toYuv(image, yuv_);
        try {
            key_ = context_->encode(yuv_, std::exchange(wantsKey_, false), bytes);
        } catch (...) {
            context_.reset();  // who knows what it takes for the picture before
            throw;
        }
        return 0.0;
    }

private:
    std::unique_ptr<Vp9Context> context_;
    YuvImage yuv_;
    bool wantsKey_ = false;
    bool key_ = false;
};

}  // namespace

uint32_t vp9Quantizer(uint32_t quality) {
    constexpr std::array<QuantizerPoint, 5> POINTS = {{{1, 60}, {25, 42}, {50, 35}, {80, 25}, {100, 4}}};
    return quantizerAt(POINTS, quality);
}

bool vp9Fits(uint32_t width, uint32_t height) { return std::max(width, height) <= LARGEST_SIDE; }

std::unique_ptr<VideoEncoder> makeVp9Encoder() { return std::make_unique<Vp9Encoder>(); }

}  // namespace heliograph

#include "server/encode/h264_encoder.h"

#include "server/encode/yuv.h"

#include <wels/codec_api.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace heliograph {

namespace {

constexpr uint32_t MACROBLOCK = 16;            // pixels wide and high
constexpr uint32_t MOST_MACROBLOCKS = 36'864;  // of level 5.2, the library's highest
constexpr uint32_t WIDEST = 8192;
constexpr float PICTURES_A_SECOND = 30.0f;  // for the level alone: the quantizer rules, not a bit rate
constexpr int ONE_THREAD = 1;

uint32_t macroblocks(uint32_t side) { return (side + MACROBLOCK - 1) / MACROBLOCK; }
uint32_t codedSide(uint32_t side) { return std::max(side + side % 2, MACROBLOCK); }

/// A plane with its last column and row repeated up to that size.
void repeatEdge(const std::vector<uint8_t>& plane, uint32_t width, uint32_t height, uint32_t toWidth, uint32_t toHeight,
                std::vector<uint8_t>& to) {
    to.resize(static_cast<size_t>(toWidth) * toHeight);
    for (uint32_t y = 0; y < toHeight; y++) {
        const auto from = plane.begin() + static_cast<ptrdiff_t>(std::min(y, height - 1)) * width;
        const auto row = to.begin() + static_cast<ptrdiff_t>(y) * toWidth;
        std::fill(std::copy(from, from + width, row), row + toWidth, from[width - 1]);
    }
}

/// The library's state for pictures of one size.
class H264Context {
public:
    H264Context(uint32_t width, uint32_t height, uint32_t quantizer) {
        check(WelsCreateSVCEncoder(&encoder_), "encoder");
        try {
            int level = WELS_LOG_QUIET;
            encoder_->SetOption(ENCODER_OPTION_TRACE_LEVEL, &level);
            encoder_->GetDefaultParams(&settings_);
            choose(static_cast<int>(width), static_cast<int>(height), static_cast<int>(quantizer));
            check(encoder_->InitializeExt(&settings_), "settings");
        } catch (...) {
            WelsDestroySVCEncoder(encoder_);
            throw;
        }
    }
    ~H264Context() {
        encoder_->Uninitialize();
        WelsDestroySVCEncoder(encoder_);
    }
    H264Context(const H264Context&) = delete;

    bool fits(uint32_t width, uint32_t height) const {
        return settings_.iPicWidth == static_cast<int>(width) && settings_.iPicHeight == static_cast<int>(height);
    }

    void setQuantizer(uint32_t quantizer) {
        int& now = settings_.sSpatialLayers[0].iDLayerQp;
        if (std::exchange(now, static_cast<int>(quantizer)) == static_cast<int>(quantizer)) return;
        check(encoder_->SetOption(ENCODER_OPTION_SVC_ENCODE_PARAM_EXT, &settings_), "quantizer");
    }

    /// Returns whether it became a key picture. `yuv` has the size that was chosen.
    bool encode(const YuvImage& yuv, bool key, std::vector<uint8_t>& bytes) {
        if (key) check(encoder_->ForceIntraFrame(true), "key picture");
        SSourcePicture picture{};
        picture.iColorFormat = videoFormatI420;
        picture.iPicWidth = settings_.iPicWidth;
        picture.iPicHeight = settings_.iPicHeight;
        picture.uiTimeStamp = time_ += 33;
        const std::array<const std::vector<uint8_t>*, 3> planes = {&yuv.y, &yuv.u, &yuv.v};
        for (size_t i = 0; i < planes.size(); i++) {
            picture.pData[i] = const_cast<uint8_t*>(planes[i]->data());  // the library reads them
            picture.iStride[i] = static_cast<int>(i == 0 ? yuv.width : yuv.colourWidth());
        }
        SFrameBSInfo coded{};
        check(encoder_->EncodeFrame(&picture, &coded), "picture");
        bytes.clear();
        for (int i = 0; i < coded.iLayerNum; i++) {
            const SLayerBSInfo& layer = coded.sLayerInfo[i];
            size_t size = 0;
            for (int unit = 0; unit < layer.iNalCount; unit++) size += static_cast<size_t>(layer.pNalLengthInByte[unit]);
            bytes.insert(bytes.end(), layer.pBsBuf, layer.pBsBuf + size);
        }
        if (bytes.empty()) throw std::runtime_error("h264: the encoder gave nothing for a picture");
        return coded.eFrameType == videoFrameTypeIDR;
    }

private:
    void choose(int width, int height, int quantizer) {
        settings_.iUsageType = CAMERA_VIDEO_REAL_TIME;
        settings_.iPicWidth = width;
        settings_.iPicHeight = height;
        settings_.fMaxFrameRate = PICTURES_A_SECOND;
        settings_.iRCMode = RC_OFF_MODE;
        settings_.iComplexityMode = LOW_COMPLEXITY;
        settings_.uiIntraPeriod = 0;  // key pictures on demand alone
        settings_.iNumRefFrame = 1;
        settings_.eSpsPpsIdStrategy = CONSTANT_ID;
        settings_.iEntropyCodingModeFlag = 0;
        settings_.iMultipleThreadIdc = ONE_THREAD;
        settings_.bEnableFrameSkip = false;
        settings_.bEnableDenoise = false;
        settings_.bEnableBackgroundDetection = false;
        settings_.bEnableAdaptiveQuant = false;
        settings_.bEnableSceneChangeDetect = false;
        settings_.bEnableLongTermReference = false;
        SSpatialLayerConfig& layer = settings_.sSpatialLayers[0];
        layer.iVideoWidth = width;
        layer.iVideoHeight = height;
        layer.fFrameRate = PICTURES_A_SECOND;
        layer.uiProfileIdc = PRO_BASELINE;
        layer.uiLevelIdc = LEVEL_UNKNOWN;  // the least that holds the picture
        layer.iDLayerQp = quantizer;
        layer.sSliceArgument.uiSliceMode = SM_SINGLE_SLICE;
        layer.bVideoSignalTypePresent = true;
        layer.uiVideoFormat = VF_UNDEF;
        layer.bFullRange = false;
        layer.bColorDescriptionPresent = true;
        layer.uiColorPrimaries = CP_BT709;
        layer.uiTransferCharacteristics = TRC_IEC61966_2_1;
        layer.uiColorMatrix = CM_BT709;
    }

    static void check(long error, const char* what) {
        if (error != cmResultSuccess)
            throw std::runtime_error(std::string("h264: ") + what + ": error " + std::to_string(error));
    }

    ISVCEncoder* encoder_ = nullptr;
    SEncParamExt settings_{};
    long long time_ = 0;  // ms
};

class H264Encoder : public VideoEncoder {
public:
    std::string mimeType() const override { return "video/h264"; }
    void wantKey() override { wantsKey_ = true; }
    bool key() const override { return key_; }

    double encode(const DisplayImage& image, uint32_t quality, std::vector<uint8_t>& bytes) override {
        if (image.width == 0 || image.height == 0) throw std::runtime_error("h264: no pixels");
        if (!h264Fits(image.width, image.height)) throw std::runtime_error("h264: too many pixels");
        toYuv(image, yuv_);
        const YuvImage& yuv = coded();
        const uint32_t quantizer = h264Quantizer(quality);
        if (context_ && !context_->fits(yuv.width, yuv.height)) context_.reset();
        try {
            if (!context_) context_ = std::make_unique<H264Context>(yuv.width, yuv.height, quantizer);
            context_->setQuantizer(quantizer);
            key_ = context_->encode(yuv, std::exchange(wantsKey_, false), bytes);
        } catch (...) {
            context_.reset();  // who knows what it takes for the picture before
            throw;
        }
        return 0.0;
    }

private:
    /// The picture in a size that the codec takes.
    const YuvImage& coded() {
        const uint32_t width = codedSide(yuv_.width), height = codedSide(yuv_.height);
        if (width == yuv_.width && height == yuv_.height) return yuv_;
        padded_.width = width;
        padded_.height = height;
        repeatEdge(yuv_.y, yuv_.width, yuv_.height, width, height, padded_.y);
        for (const auto& [from, to] : {std::pair(&yuv_.u, &padded_.u), {&yuv_.v, &padded_.v}})
            repeatEdge(*from, yuv_.colourWidth(), yuv_.colourHeight(), padded_.colourWidth(), padded_.colourHeight(), *to);
        return padded_;
    }

    std::unique_ptr<H264Context> context_;
    YuvImage yuv_, padded_;
    bool wantsKey_ = false;
    bool key_ = false;
};

}  // namespace

uint32_t h264Quantizer(uint32_t quality) {
    constexpr std::array<QuantizerPoint, 5> POINTS = {{{1, 46}, {25, 35}, {50, 31}, {80, 25}, {100, 8}}};
    return quantizerAt(POINTS, quality);
}

bool h264Fits(uint32_t width, uint32_t height) {
    return std::max(width, height) <= WIDEST && macroblocks(width) * macroblocks(height) <= MOST_MACROBLOCKS;
}

std::unique_ptr<VideoEncoder> makeH264Encoder() { return std::make_unique<H264Encoder>(); }

}  // namespace heliograph

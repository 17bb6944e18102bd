#include "server/encode/video_encoder.h"

#include "server/encode/vp9_encoder.h"
#ifdef HELIOGRAPH_OPENH264
#include "server/encode/h264_encoder.h"
#endif

#include <algorithm>
#include <stdexcept>

namespace heliograph {

uint32_t quantizerAt(std::span<const QuantizerPoint> points, uint32_t quality) {
    const uint32_t asked = std::clamp<uint32_t>(quality, 1, 100);
    size_t i = 1;
    while (points[i].quality < asked) i++;
    const QuantizerPoint &low = points[i - 1], &high = points[i];
    return low.quantizer - (low.quantizer - high.quantizer) * (asked - low.quality) / (high.quality - low.quality);
}

#ifdef HELIOGRAPH_OPENH264
bool videoBuilt(VideoCodec) { return true; }

bool videoFits(VideoCodec codec, uint32_t width, uint32_t height) {
    return codec == VideoCodec::vp9 ? vp9Fits(width, height) : h264Fits(width, height);
}

std::unique_ptr<VideoEncoder> makeVideoEncoder(VideoCodec codec) {
    return codec == VideoCodec::vp9 ? makeVp9Encoder() : makeH264Encoder();
}
#else
bool videoBuilt(VideoCodec codec) { return codec == VideoCodec::vp9; }

bool videoFits(VideoCodec codec, uint32_t width, uint32_t height) { return videoBuilt(codec) && vp9Fits(width, height); }

std::unique_ptr<VideoEncoder> makeVideoEncoder(VideoCodec codec) {
    if (!videoBuilt(codec)) throw std::runtime_error("h264: this program is built without it");
    return makeVp9Encoder();
}
#endif

}  // namespace heliograph

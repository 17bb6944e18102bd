#include "server/pace/codec_choice.h"

#include "server/pace/quality_ladder.h"

#include <algorithm>
#include <utility>

namespace heliograph {

namespace {

constexpr double CODEC_PATIENCE = 10.0;        // seconds
constexpr double MOST_CODEC_PATIENCE = 320.0;  // seconds
constexpr double CODEC_REGRET = 10.0;          // seconds in which a video shows that JPEG came too soon
constexpr double LONGEST_STEP = 0.2;           // seconds between two pictures that are one motion

}  // namespace

CodecSetting videoFor(CodecSetting setting, Videos made, Videos shown) {
    const bool both[] = {made.vp9 && shown.vp9, made.h264 && shown.h264};
    if (both[1] && (setting == CodecSetting::automatic || setting == CodecSetting::h264)) return CodecSetting::h264;
    if (both[0] && (setting == CodecSetting::automatic || setting == CodecSetting::vp9)) return CodecSetting::vp9;
    return CodecSetting::jpeg;
}

bool CodecChoice::seen(uint32_t level, double lineDelay, double viewerDelay, double now) {
    const double passed = std::min(now - std::exchange(seenAt_, now), LONGEST_STEP);
    if (!video_) {
        if (level == 0 || lineDelay < std::max(viewerDelay, TOO_LONG)) return false;
        patience_ = now - triedAt_ < CODEC_REGRET ? std::min(2.0 * patience_, MOST_CODEC_PATIENCE) : CODEC_PATIENCE;
        room_ = 0.0;
        return video_ = true;
    }
    room_ = level == 0 && lineDelay < SHORT ? room_ + passed : 0.0;
    if (room_ < patience_) return false;
    triedAt_ = now;
    video_ = false;
    return true;
}

}  // namespace heliograph

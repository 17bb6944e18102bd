#pragma once
// Whether pictures of a changing view are sent as a video, for who can decode one. A video takes a quarter of the bytes and less,
// and several times the processor time of JPEG, here and there: it is for lines that are too slow. Pure: time comes from
// outside, in seconds.

#include <cstdint>

namespace heliograph {

/// Order as in the setting `codec`.
enum class CodecSetting : uint32_t { automatic, jpeg, vp9, h264 };

/// Those that somebody can make, or show.
struct Videos {
    bool vp9 = false;
    bool h264 = false;
};

/// The video of pictures that are to be one; `jpeg` where the setting or one of the ends knows none. `automatic` takes H.264
/// before VP9: docs/measurements/feel.md.
CodecSetting videoFor(CodecSetting setting, Videos made, Videos shown);

class CodecChoice {
public:
    /// A picture of a moving view was seen. `level`: of the quality ladder. The delays are those by which pictures queue on the
    /// line and in the viewer. A video from the first step down on that is the line's doing alone; JPEG again after ten seconds of
    /// motion without a queue, and after longer each time that it was soon too slow again. True where it has changed: what the
    /// ladder has learnt is of the other codec.
    bool seen(uint32_t level, double lineDelay, double viewerDelay, double now);
    bool video() const { return video_; }
    /// Back to JPEG.
    void reset() { *this = CodecChoice(); }

private:
    bool video_ = false;
    double room_ = 0.0;       // seconds of motion without a queue
    double patience_ = 10.0;  // of them before JPEG is tried again
    double seenAt_ = 0.0;
    double triedAt_ = -1e9;  // JPEG again
};

}  // namespace heliograph

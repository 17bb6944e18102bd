#pragma once
// Pictures of a moving view as a video, each told by how it differs from the one before. For one viewer, who must be given all of
// them in order; a key picture needs none before it. No picture is held back: one goes in, one comes out.

#include "server/encode/encoder.h"

#include <memory>
#include <span>

namespace heliograph {

class VideoEncoder : public Encoder {
public:
    /// The next picture is a key picture. The first one is, too, and one of another size than that before.
    virtual void wantKey() = 0;
    /// Whether the last picture was.
    virtual bool key() const = 0;
};

/// A quantizer whose pictures look as good as JPEG of that quality.
struct QuantizerPoint {
    uint32_t quality, quantizer;
};
/// By straight lines between the points, the first of quality 1, the last of 100, which others are taken for.
uint32_t quantizerAt(std::span<const QuantizerPoint> points, uint32_t quality);

enum class VideoCodec { vp9, h264 };

/// Whether this build has the codec: H.264 only where it was asked for (HELIOGRAPH_OPENH264).
bool videoBuilt(VideoCodec codec);
/// Whether this build makes pictures of that many pixels in it. False: too many for the codec, or it is not built.
bool videoFits(VideoCodec codec, uint32_t width, uint32_t height);
/// For one thread at a time, and on that one alone. Throws std::runtime_error for a codec that is not built.
std::unique_ptr<VideoEncoder> makeVideoEncoder(VideoCodec codec);

}  // namespace heliograph

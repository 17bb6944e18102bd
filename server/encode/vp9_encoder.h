#pragma once
// VP9 by libvpx: pictures of a moving view as a video, each told by how it differs from the one before. For one viewer, who
// must be given all of them in order; a key picture needs none before it. No picture is held back: one goes in, one comes out.

#include "server/encode/encoder.h"

#include <memory>

namespace heliograph {

class VideoEncoder : public Encoder {
public:
    /// The next picture is a key picture. The first one is, too, and one of another size than that before.
    virtual void wantKey() = 0;
    /// Whether the last picture was.
    virtual bool key() const = 0;
};

/// The quantizer (0 finest to 63) whose pictures look as good as JPEG of that quality, 1..100.
uint32_t vp9Quantizer(uint32_t quality);

/// For one thread at a time, and on that one alone. Memory is taken with the first picture: 18 MB at 320x180, 78 MB at 1280x720.
std::unique_ptr<VideoEncoder> makeVp9Encoder();

}  // namespace heliograph

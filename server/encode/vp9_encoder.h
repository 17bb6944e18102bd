#pragma once
// VP9 by libvpx.

#include "server/encode/video_encoder.h"

namespace heliograph {

/// The quantizer (0 finest to 63) whose pictures look as good as JPEG of that quality, 1..100.
uint32_t vp9Quantizer(uint32_t quality);

/// Whether there are not too many pixels.
bool vp9Fits(uint32_t width, uint32_t height);

/// For one thread at a time, and on that one alone. Memory is taken with the first picture: 18 MB at 320x180, 78 MB at 1280x720.
std::unique_ptr<VideoEncoder> makeVp9Encoder();

}  // namespace heliograph

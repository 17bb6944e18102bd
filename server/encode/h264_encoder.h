#pragma once
// H.264 by OpenH264, constrained baseline, one slice a picture, Annex B; a key picture brings its parameter sets. Compiled only
// with HELIOGRAPH_OPENH264. The codec takes even sizes of at least 16 pixels: others are coded with their last column and row
// repeated, and who decodes them shows the upper left part that the frame's header names.

#include "server/encode/video_encoder.h"

namespace heliograph {

/// The quantizer (0 finest to 51) whose pictures look as good as JPEG of that quality, 1..100.
uint32_t h264Quantizer(uint32_t quality);

/// Whether there are not too many pixels: some 4096x2304.
bool h264Fits(uint32_t width, uint32_t height);

/// For one thread at a time. Memory is taken with the first picture: 2 MB at 320x180, 12 MB at 1280x720.
std::unique_ptr<VideoEncoder> makeH264Encoder();

}  // namespace heliograph

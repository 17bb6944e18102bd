#pragma once
// JPEG by libjpeg-turbo. Below quality 90 colour is stored at half resolution (4:2:0), from 90 at full (4:4:4).

#include "server/encode/encoder.h"

#include <memory>

namespace heliograph {

/// Keeps its compressor between pictures; one thread at a time.
std::unique_ptr<Encoder> makeJpegEncoder();

}  // namespace heliograph

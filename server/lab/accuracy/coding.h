#pragma once
// What coding makes of a picture that is shown.

#include "server/encode/encoder.h"

#include <cstddef>

namespace heliograph {

struct CodedPicture {
    DisplayImage image;  // decoded again
    size_t bytes = 0;
    double ms = 0.0;  // of coding, wall clock
};

/// As a viewer gets it. `quality` 1 to 100. Throws std::runtime_error.
CodedPicture codedAsJpeg(const DisplayImage& image, uint32_t quality);

}  // namespace heliograph

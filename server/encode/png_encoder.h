#pragma once
// PNG by libpng: RGB, 8 bits, marked as sRGB. Equal pictures give equal bytes.

#include "server/encode/encoder.h"

#include <memory>

namespace heliograph {

std::unique_ptr<Encoder> makePngEncoder();

}  // namespace heliograph

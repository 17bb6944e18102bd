#pragma once
// JPEG by libjpeg-turbo. Below quality 90 colour is stored at half resolution (4:2:0), from 90 at full (4:4:4). Pictures are coded
// in stripes of JPEG_STRIPE_ROWS rows, whoever codes them: the bytes do not depend on the number of threads.

#include "server/encode/encoder.h"
#include "server/encode/stripes.h"

#include <memory>

namespace heliograph {

constexpr uint32_t JPEG_STRIPE_ROWS = 64;

/// For one thread at a time.
std::unique_ptr<Encoder> makeJpegEncoder(StripeThreads threads = StripeThreads::own);

}  // namespace heliograph

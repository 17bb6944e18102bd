#pragma once
// The CPU as a device: Embree traces, the kernel shades, TBB spreads tiles over the cores.

#include "server/device/device.h"

namespace heliograph {

/// Throws std::runtime_error if Embree cannot start.
std::unique_ptr<Device> makeEmbreeDevice();

}  // namespace heliograph

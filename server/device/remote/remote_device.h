#pragma once
// A node of a pool as a device: the scheduler sees another worker, with latency.

#include "server/device/device.h"
#include "server/pool/head.h"

namespace heliograph {

/// The node of that number, "node:NUMBER". Throws std::runtime_error where it has gone.
std::unique_ptr<Device> makeRemoteDevice(std::shared_ptr<PoolHead> pool, uint32_t number);

}  // namespace heliograph

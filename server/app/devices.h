#pragma once
// The devices of this build by name: the one place that knows their classes.

#include "server/render/device.h"

#include <memory>

namespace heliograph {

/// The device that the setting `device` means; auto is the CPU. Throws std::runtime_error if it cannot start.
std::unique_ptr<Device> makeDevice(const Settings& settings);

}  // namespace heliograph

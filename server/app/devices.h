#pragma once
// The devices of this build by name: the one place that knows their classes.

#include "server/lab/raw_bench.h"
#include "server/render/device_switch.h"

#include <memory>

namespace heliograph {

/// The device that the setting `device` means; auto is a GPU where there is one, else the CPU. Behind a
/// Vulkan device stands the CPU, should it fail. Throws InputError for a device that is not there, std::runtime_error if it
/// cannot start.
std::unique_ptr<Device> makeDevice(const Settings& settings, DeviceNotice notice = {});
/// What viewers may choose: all devices that work here, or `only` these words, of which `auto` then means the first. Asks
/// the drivers once. Throws InputError for a word that is not there.
DeviceOffer deviceOffer(const std::vector<std::string>& only = {});
/// The bare tracing of the same device; null for one that offers none.
std::unique_ptr<RawBench> makeRawBench(const Settings& settings);

}  // namespace heliograph

#pragma once
// The devices of this build by name: the one place that knows their classes.

#include "server/lab/raw_bench.h"
#include "server/render/device_set.h"

#include <memory>

namespace heliograph {

/// A device by its name, "embree" or "vulkan:0". Throws InputError where there is none such, std::runtime_error if it cannot start.
std::unique_ptr<Device> makeNamed(const std::string& word);
/// The device that each request's setting `device` means; auto is a GPU where there is one, else the CPU, hybrid all of them.
/// Behind a Vulkan device stands the CPU, should it fail. For commands: hybrid waits until all its devices are ready.
/// Throws InputError where the one of `settings` is not there.
std::unique_ptr<Renderer> makeRenderer(const Settings& settings);
/// The devices of the offer with a scheduler of their own; hybrid waits until all are ready.
std::unique_ptr<Renderer> makeRenderer(DeviceOffer offer);
/// Whether "vulkan:N" is there and no processor.
bool deviceIsGpu(const std::string& name);
/// What viewers may choose: all devices that work here, or `only` these words, of which `auto` then means the first. Asks
/// the drivers once. Throws InputError for a word that is not there.
DeviceOffer deviceOffer(const std::vector<std::string>& only = {});
/// Embree on all cores but one and a Vulkan driver that computes on the processor on the last one, both forced to take part
/// in hybrid: they share the machine without sharing a core. For benchmarks; settings have to give embreeThreads. Null where
/// there is no such driver or only one core.
std::unique_ptr<Renderer> makeForcedPair(std::string& why);
/// Words of the devices that hybrid is made of.
std::vector<std::string> hybridDevices();
/// The bare tracing of the same device; null for one that offers none.
std::unique_ptr<RawBench> makeRawBench(const Settings& settings);

}  // namespace heliograph

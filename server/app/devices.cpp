#include "server/app/devices.h"

#include "server/device/embree/embree_device.h"

#include <stdexcept>

namespace heliograph {

std::unique_ptr<Device> makeDevice(const Settings& settings) {
    std::string word = Settings::choiceWord("device", settings.device);
    if (word == "auto" || word == "embree") return makeEmbreeDevice();
    throw std::runtime_error("device " + word + ": not part of this build");
}

std::unique_ptr<RawBench> makeRawBench(const Settings&) { return nullptr; }

}  // namespace heliograph

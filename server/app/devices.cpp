#include "server/app/devices.h"

#include "server/device/embree/embree_device.h"
#include "server/device/embree/embree_raw.h"

#include <stdexcept>

namespace heliograph {

std::unique_ptr<Device> makeDevice(const Settings& settings) {
    std::string word = Settings::choiceWord("device", settings.device);
    if (word == "auto" || word == "embree") return makeEmbreeDevice();
    throw std::runtime_error("device " + word + ": not part of this build");
}

namespace {

RawTime rawTime(const BareTime& time) { return {time.wallMs, time.coreMs, time.rays}; }

class EmbreeRawBench : public RawBench {
public:
    void prepare(std::shared_ptr<const Scene> scene, const FrameRequest& request) override {
        raw_.prepare(std::move(scene), request);
    }
    RawTimes measure() override {
        RawTimes times;
        times.primary = rawTime(raw_.trace(RayKind::primary));
        times.shadow = rawTime(raw_.trace(RayKind::shadow));
        times.ambientOcclusion = rawTime(raw_.trace(RayKind::ambientOcclusion));
        return times;
    }

private:
    EmbreeRaw raw_;
};

}  // namespace

std::unique_ptr<RawBench> makeRawBench(const Settings& settings) {
    std::string word = Settings::choiceWord("device", settings.device);
    if (word == "auto" || word == "embree") return std::make_unique<EmbreeRawBench>();
    return nullptr;
}

}  // namespace heliograph

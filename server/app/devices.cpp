#include "server/app/devices.h"

#include "server/device/embree/embree_device.h"
#include "server/device/embree/embree_raw.h"

#include "server/device/vulkan/raster_device.h"
#include "server/device/vulkan/vulkan_device.h"
#include "server/render/spare_device.h"

namespace heliograph {

namespace {

// A Vulkan device that is no processor: only that is faster than Embree.
bool hasGpu() {
    std::string why;
    for (const PhysicalDevice& device : listVulkanDevices(why))
        if (device.refused.empty() && !device.isCpu()) return true;
    return false;
}

// A GPU can be lost; the processor cannot.
std::unique_ptr<Device> withSpare(std::unique_ptr<Device> device) {
    return makeSpareDevice(std::move(device), makeEmbreeDevice());
}

}  // namespace

std::unique_ptr<Device> makeDevice(const Settings& settings) {
    std::string word = Settings::choiceWord("device", settings.device);
    if (word == "auto") return hasGpu() ? withSpare(makeVulkanDevice()) : makeEmbreeDevice();
    if (word == "vulkan") return withSpare(makeVulkanDevice());
    if (word.starts_with("vulkan:")) return withSpare(makeVulkanDevice(word.substr(7)));
    if (word == "raster") return makeRasterDevice();
    return makeEmbreeDevice();
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

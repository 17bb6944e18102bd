#include "server/app/devices.h"

#include "server/device/embree/embree_device.h"
#include "server/device/embree/embree_raw.h"

#include "server/device/vulkan/raster_device.h"
#include "server/device/vulkan/vulkan_device.h"
#include "server/base/error.h"
#include "server/render/spare_device.h"

#include <algorithm>

namespace heliograph {

namespace {

/// The physical devices that can trace.
std::vector<PhysicalDevice> usableVulkanDevices() {
    std::string why;
    std::vector<PhysicalDevice> devices = listVulkanDevices(why);
    std::erase_if(devices, [](const PhysicalDevice& device) { return !device.refused.empty(); });
    return devices;
}

// A Vulkan device that is no processor: only that is faster than Embree.
bool isGpu(const PhysicalDevice& device) { return !device.isCpu(); }

std::string joined(const std::vector<std::string>& words) {
    std::string line;
    for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
    return line;
}

std::unique_ptr<Device> makeNamed(const std::string& word, DeviceNotice notice) {
    if (word == "raster") return makeRasterDevice();
    if (!word.starts_with("vulkan")) return makeEmbreeDevice();
    // A GPU can be lost; the processor cannot.
    return makeSpareDevice(makeVulkanDevice(word.size() > 7 ? word.substr(7) : ""), makeEmbreeDevice(), std::move(notice));
}

}  // namespace

std::unique_ptr<Device> makeDevice(const Settings& settings, DeviceNotice notice) {
    std::string word = Settings::choiceWord("device", settings.device);
    if (word == "auto") word = std::ranges::any_of(usableVulkanDevices(), isGpu) ? "vulkan" : "embree";
    return makeNamed(word, std::move(notice));
}

DeviceOffer deviceOffer(const std::vector<std::string>& only) {
    DeviceOffer offer;
    offer.words = {"auto", "embree"};
    const std::vector<PhysicalDevice> devices = usableVulkanDevices();
    const auto gpu = std::ranges::find_if(devices, isGpu);
    std::string best = "vulkan";
    if (!devices.empty()) {
        best = "vulkan:" + std::to_string((gpu != devices.end() ? *gpu : devices.front()).index);
        offer.words.push_back("vulkan");
    }
    for (const PhysicalDevice& device : devices) {
        std::string word = "vulkan:" + std::to_string(device.index);
        if (device.index < 4) offer.words.push_back(word);  // the setting's choices end there
    }
    if (std::ranges::any_of(devices, &PhysicalDevice::graphics)) offer.words.push_back("raster");
    std::string automatic = gpu != devices.end() ? best : "embree";
    for (const std::string& word : only) {
        if (std::ranges::find(offer.words, word) == offer.words.end())
            throw InputError("--devices", word + " is not here", "a list of " + joined(offer.words) + " (see heliograph devices)");
    }
    if (!only.empty() && only.front() != "auto") automatic = only.front() == "vulkan" ? best : only.front();
    if (std::ranges::find(only, "auto") == only.end() && !only.empty()) {
        offer.words = {"auto"};
        offer.words.insert(offer.words.end(), only.begin(), only.end());
    }
    offer.nameOf = [=](const Settings& settings) {
        std::string word = Settings::choiceWord("device", settings.device);
        return word == "auto" ? automatic : word == "vulkan" ? best : word;
    };
    offer.make = makeNamed;
    return offer;
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

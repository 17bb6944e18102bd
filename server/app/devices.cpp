#include "server/app/devices.h"

#include "server/base/text.h"
#include "server/device/embree/embree_device.h"
#include "server/device/embree/embree_raw.h"

#include "server/device/vulkan/raster/raster_device.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/base/error.h"
#include "server/request/device_rows.h"

#include <algorithm>
#include <thread>

namespace heliograph {

namespace {

/// The physical devices that can trace.
std::vector<PhysicalDevice> usableVulkanDevices() {
    std::string why;
    std::vector<PhysicalDevice> devices = listVulkanDevices(why);
    std::erase_if(devices, [](const PhysicalDevice& device) { return !device.refused.empty(); });
    return devices;
}

/// Nodes are devices of a pool (pool_devices.h).
std::unique_ptr<Device> makePoolNode(const std::string& which) {
    throw InputError("device", "node:" + which, "with --pool, a node that is there");
}

// A Vulkan device that is no processor: only that is faster than Embree.
bool isGpu(const PhysicalDevice& device) { return !device.isCpu(); }

}  // namespace

std::unique_ptr<Device> makeNamed(const std::string& word) {
    const size_t colon = word.find(':');
    const std::string name = word.substr(0, colon);
    const std::string which = colon == std::string::npos ? "" : word.substr(colon + 1);
#define DEVICE(row, bit, kind, side, words, onSwitch, standIn, make) \
    if (name == #row) return make;
#include "server/request/device_table.inc"
    throw InputError("device", word, "a row of device_table.inc");
}

namespace {

/// A device set with a scheduler of its own.
class CommandRenderer : public Renderer {
public:
    explicit CommandRenderer(DeviceOffer offer, bool forced = false)
        : inner_(makeDeviceSet(std::move(offer), scheduler_, {{}, true, forced})) {}
    DeviceInfo info() const override { return inner_->info(); }
    DeviceInfo infoFor(const Settings& settings) const override { return inner_->infoFor(settings); }
    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        inner_->load(std::move(scene), settings, progress);
    }
    void prepare(const Settings& settings) override { inner_->prepare(settings); }
    ScheduleReport render(const FrameRequest& request, std::span<const Tile> tiles, ViewMemory& view, const TileSink& sink,
                          std::stop_token stop) override {
        return inner_->render(request, tiles, view, sink, stop);
    }
    bool denoise(const Settings& settings, DenoiseJob& job) override { return inner_->denoise(settings, job); }
    DepthAnswer depthAlong(const ViewRay& ray) override { return inner_->depthAlong(ray); }

private:
    TileScheduler scheduler_;
    std::unique_ptr<Renderer> inner_;
};

}  // namespace

std::unique_ptr<Renderer> makeRenderer(const Settings& settings) {
    DeviceOffer offer = deviceOffer();
    const std::string word = Settings::choiceWord("device", settings.device);
    // The offer has what is here; asking for something else by name gives the driver's own answer why not.
    if (std::ranges::find(offer.words, word) == offer.words.end()) makeNamed(word);
    return std::make_unique<CommandRenderer>(std::move(offer));
}

std::unique_ptr<Renderer> makeRenderer(DeviceOffer offer) { return std::make_unique<CommandRenderer>(std::move(offer)); }

bool deviceIsGpu(const std::string& name) {
    return std::ranges::any_of(usableVulkanDevices(), [&](const PhysicalDevice& device) {
        return isGpu(device) && numberedDevice(device_name::vulkan, device.index) == name;
    });
}

std::vector<std::string> hybridDevices() { return deviceOffer().team; }

std::unique_ptr<Renderer> makeForcedPair(std::string& why) {
    const std::vector<PhysicalDevice> devices = usableVulkanDevices();
    const auto cpu = std::ranges::find_if(devices, &PhysicalDevice::isCpu);
    if (cpu == devices.end()) why = "no Vulkan driver that computes on the processor";
    else if (std::thread::hardware_concurrency() < 2) why = "only one core";
    if (!why.empty()) return nullptr;
    DeviceOffer offer;
    const std::string vulkan = numberedDevice(device_name::vulkan, cpu->index);
    offer.words = offer.team = {std::string(device_name::embree), vulkan};
    offer.words.push_back("hybrid");
    offer.nameOf = [](const Settings& settings) { return Settings::choiceWord("device", settings.device); };
    offer.make = [](const std::string& word) -> std::unique_ptr<Device> {
        if (word == device_name::embree) return makeEmbreeDevice();
        VulkanOptions pinned;
        pinned.lastCoreOnly = true;
        return makeVulkanDevice(word.substr(word.find(':') + 1), pinned);
    };
    return std::make_unique<CommandRenderer>(std::move(offer), true);
}

DeviceOffer deviceOffer(const std::vector<std::string>& only) {
    DeviceOffer offer;
    const std::string embree(device_name::embree), vulkan(device_name::vulkan), raster(device_name::raster);
    offer.words = {"auto", embree};
    const std::vector<PhysicalDevice> devices = usableVulkanDevices();
    const auto gpu = std::ranges::find_if(devices, isGpu);
    std::string best = vulkan;
    if (!devices.empty()) {
        best = numberedDevice(vulkan, (gpu != devices.end() ? *gpu : devices.front()).index);
        offer.words.push_back(vulkan);
    }
    for (const PhysicalDevice& device : devices) {
        std::string word = numberedDevice(vulkan, device.index);
        if (device.index < 4) offer.words.push_back(word);  // the setting's choices end there
    }
    if (std::ranges::any_of(devices, &PhysicalDevice::graphics)) offer.words.push_back(raster);
    for (const DeviceRow& row : deviceRows()) {
        const bool isElsewhere = row.kind == DeviceKind::gpu || row.kind == DeviceKind::preview || row.kind == DeviceKind::node;
        if (!isElsewhere && row.name != embree) offer.words.emplace_back(row.name);
    }
    offer.words.push_back("hybrid");
    auto asked = [&](const std::string& word) { return only.empty() || std::ranges::find(only, word) != only.end(); };
    const bool everything = asked("auto") || asked("hybrid");
    auto joins = [&](const std::string& word) {
        if (everything || asked(word) || (word == best && asked(vulkan))) offer.team.push_back(word);
    };
    joins(embree);
    for (const PhysicalDevice& device : devices) joins(numberedDevice(vulkan, device.index));
    offer.fallback = embree;
    std::string automatic = gpu != devices.end() ? best : embree;
    for (const std::string& word : only) {
        if (std::ranges::find(offer.words, word) == offer.words.end())
            throw InputError("--devices", word + " is not here",
                             "a list of " + joined(offer.words, " ") + " (see heliograph devices)");
    }
    if (!only.empty() && only.front() != "auto") automatic = only.front() == vulkan ? best : only.front();
    if (std::ranges::find(only, "auto") == only.end() && !only.empty()) {
        offer.words = {"auto"};
        offer.words.insert(offer.words.end(), only.begin(), only.end());
        if (!asked("hybrid") && offer.team.size() > 1) offer.words.push_back("hybrid");
    }
    offer.nameOf = [=](const Settings& settings) {
        std::string word = Settings::choiceWord("device", settings.device);
        return word == "auto" ? automatic : word == vulkan ? best : word;
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
    if (word == "auto" || word == device_name::embree) return std::make_unique<EmbreeRawBench>();
    return nullptr;
}

}  // namespace heliograph

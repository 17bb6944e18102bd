#include "server/render/device_switch.h"

#include "server/base/log.h"

#include <map>
#include <mutex>

namespace heliograph {

namespace {

class DeviceSwitch : public Device {
public:
    DeviceSwitch(DeviceOffer offer, DeviceNotice notice) : offer_(std::move(offer)), notice_(std::move(notice)) {}

    DeviceInfo info() const override {
        std::shared_ptr<Entry> entry = find(first_);
        return entry ? entry->device->info() : DeviceInfo{};
    }

    DeviceInfo infoFor(const Settings& settings) const override {
        std::shared_ptr<Entry> entry = find(offer_.nameOf(settings));
        return entry ? entry->device->infoFor(settings) : info();
    }

    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        {
            std::lock_guard lock(mutex_);
            entries_.clear();
            scene_ = std::move(scene);
            first_ = offer_.nameOf(settings);
        }
        ready(settings, progress);
    }

    void prepare(const Settings& settings) override { ready(settings, {})->device->prepare(settings); }

    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                std::stop_token stop) override {
        ready(request.settings, {})->device->render(request, tiles, sink, stop);
    }

private:
    struct Entry {
        std::mutex loading;
        std::unique_ptr<Device> device;  // null until it holds the scene
    };

    std::shared_ptr<Entry> find(const std::string& name) const {
        std::lock_guard lock(mutex_);
        auto found = entries_.find(name);
        return found != entries_.end() && found->second->device ? found->second : nullptr;
    }

    /// The device that the settings name, with the scene. Devices do not wait for each other's loading.
    std::shared_ptr<Entry> ready(const Settings& settings, const Progress& progress) {
        const std::string name = offer_.nameOf(settings);
        if (std::shared_ptr<Entry> entry = find(name)) return entry;
        std::shared_ptr<Entry> entry;
        std::shared_ptr<const Scene> scene;
        {
            std::lock_guard lock(mutex_);
            std::shared_ptr<Entry>& slot = entries_[name];
            if (!slot) slot = std::make_shared<Entry>();
            entry = slot;
            scene = scene_;
        }
        std::lock_guard loading(entry->loading);
        if (find(name)) return entry;
        log().debug("starting {}", name);
        std::unique_ptr<Device> device = offer_.make(name, notice_);
        device->load(scene, settings, progress);
        std::lock_guard lock(mutex_);
        entry->device = std::move(device);
        return entry;
    }

    const DeviceOffer offer_;
    const DeviceNotice notice_;
    mutable std::mutex mutex_;
    std::string first_;
    std::shared_ptr<const Scene> scene_;
    std::map<std::string, std::shared_ptr<Entry>> entries_;
};

}  // namespace

std::unique_ptr<Device> makeDeviceSwitch(DeviceOffer offer, DeviceNotice notice) {
    return std::make_unique<DeviceSwitch>(std::move(offer), std::move(notice));
}

}  // namespace heliograph

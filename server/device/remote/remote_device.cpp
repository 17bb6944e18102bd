#include "server/device/remote/remote_device.h"

namespace heliograph {

namespace {

/// Batches that a node has at once: one in work, and one that waits while the first one's results travel.
constexpr uint32_t STREAMS = 2;
/// Fixed cost of a batch: its message, a wake-up here and there.
constexpr double BATCH_SECONDS = 0.0005;

class RemoteDevice : public Device {
public:
    RemoteDevice(std::shared_ptr<PoolHead> pool, uint32_t number)
        : pool_(std::move(pool)), number_(number), name_(numberedDevice(device_name::node, number)) {
        const std::optional<PoolNode> node = pool_->node(number);
        if (!node) throw std::runtime_error(name_ + " has left the pool");
        info_.name = name_;
        info_.details = node->name + ", " + node->hardware;
        info_.hardware = name_;
        info_.workers = info_.streams = STREAMS;
        info_.batchSeconds = BATCH_SECONDS;
        info_.stampsTiles = false;
        info_.queues = true;
    }

    DeviceInfo info() const override {
        DeviceInfo info = info_;
        if (const std::optional<PoolNode> node = pool_->node(number_)) info.roundTrip = node->roundTrip;
        return info;
    }
    DeviceInfo infoFor(const Settings&) const override { return info(); }

    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        parts_.reset();
        std::shared_ptr<const SceneParts> parts = pool_->offer(std::move(scene));
        pool_->load(number_, parts->name(), settings, progress);
        parts_ = std::move(parts);
    }

    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        if (!parts_) throw std::runtime_error(name_ + ": render without a scene");
        pool_->render(number_, parts_->name(), request, tiles, name_, sink, stop);
    }

private:
    const std::shared_ptr<PoolHead> pool_;
    const uint32_t number_;
    const std::string name_;
    DeviceInfo info_;
    std::shared_ptr<const SceneParts> parts_;  // that the node may ask for
};

}  // namespace

std::unique_ptr<Device> makeRemoteDevice(std::shared_ptr<PoolHead> pool, uint32_t number) {
    return std::make_unique<RemoteDevice>(std::move(pool), number);
}

}  // namespace heliograph

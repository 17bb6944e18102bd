#include "server/render/spare_device.h"

#include "server/base/log.h"

#include <atomic>
#include <mutex>
#include <set>

namespace heliograph {

namespace {

/// What tells the tiles of one call apart.
using TileKey = std::array<uint32_t, 3>;
TileKey keyOf(const Tile& tile) { return {tile.origin.x, tile.origin.y, tile.firstSample}; }

class SpareDevice : public Device {
public:
    SpareDevice(std::unique_ptr<Device> first, std::unique_ptr<Device> spare, DeviceNotice notice)
        : first_(std::move(first)), spare_(std::move(spare)), notice_(std::move(notice)) {}

    DeviceInfo info() const override { return aside_ ? spare_->info() : first_->info(); }

    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        std::lock_guard lock(mutex_);
        scene_ = std::move(scene);
        spareLoaded_ = false;
        if (!aside_) {
            try {
                first_->load(scene_, settings, progress);
                return;
            } catch (const std::exception& error) {
                setAside(error.what());
            }
        }
        loadSpare(settings, progress);
    }

    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                std::stop_token stop) override {
        std::vector<Tile> left(tiles.begin(), tiles.end());
        if (!aside_) {
            std::mutex deliveredMutex;
            std::set<TileKey> delivered;
            auto counting = [&](TileResult&& result) {
                TileKey key = keyOf(result.tile);
                sink(std::move(result));
                std::lock_guard lock(deliveredMutex);
                delivered.insert(key);
            };
            try {
                first_->render(request, tiles, counting, stop);
                return;
            } catch (const std::exception& error) {
                setAside(error.what());
            }
            std::erase_if(left, [&](const Tile& tile) { return delivered.contains(keyOf(tile)); });
        }
        {
            std::lock_guard lock(mutex_);
            loadSpare(request.settings, {});
        }
        spare_->render(request, left, sink, stop);
    }

private:
    void setAside(const std::string& why) {
        if (aside_.exchange(true)) return;
        std::string text = "device " + first_->info().name + " was set aside: " + why + "; " + spare_->info().name + " goes on";
        log().warn("{}", text);
        if (notice_) notice_(text);
    }

    void loadSpare(const Settings& settings, const Progress& progress) {
        if (spareLoaded_) return;
        spare_->load(scene_, settings, progress);
        spareLoaded_ = true;
    }

    std::unique_ptr<Device> first_;
    std::unique_ptr<Device> spare_;
    DeviceNotice notice_;
    std::atomic<bool> aside_{false};
    std::mutex mutex_;
    std::shared_ptr<const Scene> scene_;
    bool spareLoaded_ = false;
};

}  // namespace

std::unique_ptr<Device> makeSpareDevice(std::unique_ptr<Device> first, std::unique_ptr<Device> spare, DeviceNotice notice) {
    return std::make_unique<SpareDevice>(std::move(first), std::move(spare), std::move(notice));
}

}  // namespace heliograph

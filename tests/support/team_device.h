#pragma once
// A device with streams that a test can slow down, hold up, break or make lie. Its pixels are those of FakeDevice.

#include "server/device/device.h"

#include <atomic>
#include <condition_variable>
#include <mutex>

namespace heliograph::test {

class TeamDevice : public Device {
public:
    explicit TeamDevice(std::string name, uint32_t streams = 1, std::string hardware = {});
    DeviceInfo info() const override;
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override;
    void warmUp(const FrameRequest&) override;
    Warmth warmth(const FrameRequest&) const override {
        return !cold ? Warmth::warm : standsBy ? Warmth::generic : Warmth::cold;
    }
    void standBy() override { standBys++; }
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override;
    void renderStream(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                      std::stop_token stop) override;

    /// Calls wait before the next tile until `release`; they do not even listen to `stop`.
    void hold();
    void release();
    /// Until so many calls wait there.
    bool untilHeld(int calls = 1);

    /// Origins of the tiles of each call of renderStream.
    std::vector<std::vector<uvec2>> asked();
    void forgetAsked();

    std::atomic<int> throwAfter{-1};       // tiles, over all calls
    std::atomic<bool> outOfMemory{false};  // what it throws then is std::bad_alloc
    std::atomic<bool> leavesOut{false};    // the last tile of each call
    std::atomic<bool> everyTwice{false};
    std::atomic<bool> wrongSizes{false};  // its tiles are half of what was asked for
    std::atomic<double> stamp{1e-4};      // seconds that it claims for a tile
    std::atomic<int> spins{0};            // work a tile
    std::atomic<bool> failsToLoad{false};
    bool overlaps = false;              // see DeviceInfo
    std::atomic<bool> cold{false};      // until it is warmed up
    std::atomic<bool> standsBy{false};  // serves when cold, too
    std::atomic<uint32_t> tiles{0}, calls{0}, loads{0}, warmUps{0}, standBys{0};

private:
    void waitHere();

    const std::string name_, hardware_;
    const uint32_t streams_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool held_ = false;
    std::vector<std::vector<uvec2>> asked_;
    int waiting_ = 0;
};

}  // namespace heliograph::test

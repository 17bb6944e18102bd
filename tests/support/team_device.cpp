#include "tests/support/team_device.h"

#include "tests/support/fake_device.h"

#include <chrono>
#include <new>
#include <stdexcept>

namespace heliograph::test {

namespace {

using namespace std::chrono_literals;

constexpr auto PATIENCE = 30s;  // until a test that waits for something gives up

TileResult made(const Tile& tile, const std::string& device, double stamp) {
    TileResult result = fakeResult(tile, device);
    result.seconds = stamp;
    return result;
}

}  // namespace

TeamDevice::TeamDevice(std::string name, uint32_t streams, std::string hardware)
    : name_(std::move(name)), hardware_(hardware.empty() ? name_ : std::move(hardware)), streams_(streams) {}

DeviceInfo TeamDevice::info() const {
    DeviceInfo info{name_, "for tests", hardware_, streams_};
    info.streams = streams_;
    info.batchSeconds = 1e-6;
    info.overlaps = overlaps;
    return info;
}

void TeamDevice::load(std::shared_ptr<const Scene>, const Settings&, const Progress&) {
    loads++;
    waitHere();
    if (failsToLoad) throw std::runtime_error(name_ + " does not start");
}

void TeamDevice::warmUp(const FrameRequest&) {
    waitHere();
    warmUps++;
    cold = false;
}

void TeamDevice::render(const FrameRequest& request, std::span<const Tile> wanted, const TileSink& sink, std::stop_token stop) {
    renderStream(request, wanted, sink, stop);
}

void TeamDevice::renderStream(const FrameRequest&, std::span<const Tile> wanted, const TileSink& sink, std::stop_token stop) {
    calls++;
    {
        std::lock_guard lock(mutex_);
        std::vector<uvec2>& origins = asked_.emplace_back();
        for (const Tile& tile : wanted) origins.push_back(tile.origin);
    }
    for (size_t i = 0; i < wanted.size() && !stop.stop_requested(); i++) {
        waitHere();
        if (throwAfter >= 0 && throwAfter-- <= 0) {
            throwAfter = 0;
            if (outOfMemory) throw std::bad_alloc();
            throw std::runtime_error(name_ + " is lost");
        }
        if (leavesOut && i + 1 == wanted.size()) return;
        for (int spin = spins; spin > 0; spin--) std::atomic_signal_fence(std::memory_order_seq_cst);
        Tile tile = wanted[i];
        if (wrongSizes) tile.size.y = std::max(1u, tile.size.y / 2);
        tiles++;
        sink(made(tile, name_, stamp));
        if (everyTwice) sink(made(tile, name_, stamp));
    }
}

void TeamDevice::waitHere() {
    std::unique_lock lock(mutex_);
    if (!held_) return;
    waiting_++;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !held_; });
    waiting_--;
}

std::vector<std::vector<uvec2>> TeamDevice::asked() {
    std::lock_guard lock(mutex_);
    return asked_;
}

void TeamDevice::forgetAsked() {
    std::lock_guard lock(mutex_);
    asked_.clear();
}

void TeamDevice::hold() {
    std::lock_guard lock(mutex_);
    held_ = true;
}

void TeamDevice::release() {
    std::lock_guard lock(mutex_);
    held_ = false;
    changed_.notify_all();
}

bool TeamDevice::untilHeld(int count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, PATIENCE, [&] { return waiting_ >= count; });
}

}  // namespace heliograph::test

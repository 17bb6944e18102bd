#pragma once
// A device that traces nothing: its pixels follow from position and sample index by a formula that tests know.

#include "server/device/device.h"

namespace heliograph::test {

/// Radiance of sample `sample` of pixel (x, y).
vec4 fakeRadiance(uint32_t x, uint32_t y, uint32_t sample);

/// All of a tile's samples by that formula; one camera ray each.
TileResult fakeResult(const Tile& tile, const std::string& device);

class FakeDevice : public Device {
public:
    DeviceInfo info() const override { return {"fake", "for tests", "none", threads}; }
    void load(std::shared_ptr<const Scene> scene, const Settings&, const Progress& progress) override;
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override;

    uint32_t threads = 1;        // that deliver at the same time
    bool backwards = false;      // last tile first
    bool everyTwice = false;     // delivers each result twice
    size_t leaveOut = SIZE_MAX;  // index of a tile that is never delivered
    std::function<void()> afterEachTile;
    std::vector<FrameRequest> requests;  // one per call of render
    std::shared_ptr<const Scene> scene;
};

}  // namespace heliograph::test

#include "tests/support/fake_device.h"

#include <atomic>
#include <thread>

namespace heliograph::test {

namespace {

TileResult made(const Tile& tile) {
    TileResult result = fakeResult(tile, "fake");
    result.rays[RayKind::shadow] = 2;
    result.nonfiniteSamples = 1;
    return result;
}

}  // namespace

vec4 fakeRadiance(uint32_t x, uint32_t y, uint32_t sample) {
    uint32_t hash = (x * 73856093u) ^ (y * 19349663u) ^ (sample * 83492791u);
    float grey = static_cast<float>((hash >> 8) & 0xffffu) / 65536.0f;
    vec3 color(grey, 0.5f * grey, 1.0f - grey);
    float luminance = LUMINANCE_RED * color.x + LUMINANCE_GREEN * color.y + LUMINANCE_BLUE * color.z;
    return vec4(color, luminance * luminance);
}

TileResult fakeResult(const Tile& tile, const std::string& device) {
    TileResult result;
    result.tile = tile;
    result.device = device;
    result.rays[RayKind::primary] = static_cast<uint64_t>(tile.size.x) * tile.size.y * tile.sampleCount;
    for (uint32_t y = 0; y < tile.size.y; y++) {
        for (uint32_t x = 0; x < tile.size.x; x++) {
            vec4 sum(0.0f);
            for (uint32_t s = 0; s < tile.sampleCount; s++) {
                sum += fakeRadiance(tile.origin.x + x, tile.origin.y + y, tile.firstSample + s);
            }
            result.radianceSum.push_back(sum);
        }
    }
    return result;
}

void FakeDevice::load(std::shared_ptr<const Scene> loaded, const Settings&, const Progress& progress) {
    scene = std::move(loaded);
    report(progress, "pretending", 1.0);
}

void FakeDevice::render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) {
    requests.push_back(request);
    std::atomic<size_t> next = 0;
    auto work = [&] {
        for (size_t i = next++; i < tiles.size() && !stop.stop_requested(); i = next++) {
            size_t index = backwards ? tiles.size() - 1 - i : i;
            if (index == leaveOut) continue;
            sink(made(tiles[index]));
            if (everyTwice) sink(made(tiles[index]));
            if (afterEachTile) afterEachTile();
        }
    };
    std::vector<std::jthread> helpers;
    for (uint32_t i = 1; i < threads; i++) helpers.emplace_back(work);
    work();
}

}  // namespace heliograph::test

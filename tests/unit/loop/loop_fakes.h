#pragma once
// A view whose device paints what it was asked for, and who looks at it.

#include "server/loop/frame_loop.h"

#include "server/scene/scene.h"

#include "tests/support/direct_renderer.h"
#include "tests/support/random.h"
#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <random>

namespace heliograph::loop_test {

using namespace std::chrono_literals;

inline constexpr auto PATIENCE = 30s;  // until a test that waits for something gives up

/// Paints every pixel with the camera's position, and can be held up before a tile.
class PaintDevice : public Device {
public:
    DeviceInfo info() const override { return {"embree", "for tests", "none", 1}; }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        if (inside.fetch_add(1) != 0) overlapped = true;
        calls++;
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) break;
            std::unique_lock lock(mutex);
            arrived++;
            changed.notify_all();
            changed.wait(lock, stop, [&] { return !held; });
            if (stop.stop_requested()) break;
            lock.unlock();
            if (broken) throw std::runtime_error("device lost");
            if (slow) std::this_thread::sleep_for(20us * tile.size.x * tile.size.y);
            TileResult result;
            result.tile = tile;
            result.device = "embree";
            result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, vec4(request.camera.position, 0.0f));
            if (grainy) {
                for (size_t i = 0; i < result.radianceSum.size(); i++) {
                    const float depth = result.tile.origin.x < calmUntil ? 0.001f : 0.5f;
                    const float grey = chance.word() & 1u ? 1.0f + depth : 1.0f - depth;
                    result.radianceSum[i] = vec4(vec3(grey), grey * grey);
                }
            }
            result.rays[RayKind::primary] = result.radianceSum.size();
            sink(std::move(result));
        }
        inside--;
    }

    DepthAnswer depthAlong(const ViewRay& ray) override {
        std::unique_lock lock(mutex);
        depthCalls++;
        changed.notify_all();
        changed.wait(lock, [&] { return !depthHeld; });
        return {true, ray.origin.x};
    }

    void hold(bool on) {
        std::lock_guard lock(mutex);
        held = on;
        arrived = 0;
        changed.notify_all();
    }
    /// Until a tile waits to be let through.
    void untilArrived() {
        std::unique_lock lock(mutex);
        ASSERT_TRUE(changed.wait_for(lock, PATIENCE, [&] { return arrived > 0; }));
    }

    /// Until render was called so many times.
    void untilCalled(int times) {
        std::unique_lock lock(mutex);
        ASSERT_TRUE(changed.wait_for(lock, PATIENCE, [&] { return calls >= times; }));
    }

    std::atomic<int> inside{0}, calls{0};
    std::atomic<bool> overlapped{false}, broken{false}, slow{false}, grainy{false};
    std::atomic<uint32_t> calmUntil{0};  // column of pixels, of a grainy picture
    test::Random chance{3};
    std::mutex mutex;
    std::condition_variable_any changed;
    bool held = false, depthHeld = false;
    int arrived = 0, depthCalls = 0;
};

/// Keeps what the loop hands over. Credit is given by the test.
class Onlooker : public FrameReceiver {
public:
    Readiness readiness() override {
        std::lock_guard lock(mutex);
        return credit > 0 ? Readiness::ready : Readiness::noCredit;
    }
    void take(FinishedFrame&& frame) override {
        std::lock_guard lock(mutex);
        if (!frame.picture) credit--;
        frame.film->develop(pixels);
        frame.film.reset();  // as the encoder does in the end
        frames.push_back(std::move(frame));
        colors.push_back(pixels.empty() ? vec4(0.0f) : pixels.back());
        changed.notify_all();
    }
    void pathEnded(const FrameSummary& result) override {
        std::lock_guard lock(mutex);
        runs.push_back(result);
        changed.notify_all();
    }
    void focused(const FocusRequest& request, const DepthAnswer& answer) override {
        std::lock_guard lock(mutex);
        focuses.push_back({request.inputId, answer.depth.value_or(-1.0)});
        changed.notify_all();
    }
    void picked(const PickRequest& request, const DepthAnswer& answer, const Scene&) override {
        std::lock_guard lock(mutex);
        picks.push_back({request.id, answer.depth.value_or(-1.0)});
        changed.notify_all();
    }
    void failed(const std::string& what) override {
        std::lock_guard lock(mutex);
        failures.push_back(what);
        changed.notify_all();
    }
    template <typename Condition>
    bool until(Condition condition) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, PATIENCE, condition);
    }
    void give(int more, FrameLoop& loop) {
        {
            std::lock_guard lock(mutex);
            credit += more;
        }
        loop.wake();
    }

    std::mutex mutex;
    std::condition_variable changed;
    int credit = 1'000'000;
    std::vector<FinishedFrame> frames;
    std::vector<vec4> colors;  // of the last pixel of each
    std::vector<FrameSummary> runs;
    std::vector<std::string> failures;
    std::vector<std::pair<uint32_t, double>> focuses;  // input id and depth
    std::vector<std::pair<uint32_t, double>> picks;    // id and depth
    std::vector<vec4> pixels;
};

inline std::shared_ptr<ResidentScene> sceneOn(std::shared_ptr<Device> device, bool withPath = false) {
    auto scene = std::make_shared<Scene>();
    scene->name = "empty";
    scene->environment.image = NO_INDEX;
    scene->cameras.push_back({"start"});
    if (withPath) {
        CameraPath path;
        path.seconds = 0.2f;
        path.keys = {{vec3(5, 0, 0), vec3(0)}, {vec3(0, 0, 5), vec3(0)}, {vec3(-5, 0, 0), vec3(0)}};
        scene->paths.push_back(path);
    }
    return std::make_shared<ResidentScene>(
        ResidentScene{scene, std::make_shared<test::DirectRenderer>(std::move(device)), {}, {}});
}

/// Input `id` looks from (id, 0, 0).
inline ViewRequest inputFrom(uint32_t id, uint32_t samples = 1) {
    ViewRequest request;
    request.camera.position = vec3(static_cast<float>(id), 0.0f, 0.0f);
    request.resolution = {96, 64};
    request.settings.samples = samples;
    request.inputId = id;
    request.received = std::chrono::steady_clock::now();
    return request;
}

struct Stage {
    std::shared_ptr<PaintDevice> device = std::make_shared<PaintDevice>();
    Onlooker viewer;
    Turns turns;
    FrameLoop loop{turns, viewer};
};

}  // namespace heliograph::loop_test

// A load that is given up inside Embree, and what a device leaves behind on the threads that call it.

#include "server/device/embree/embree_device.h"
#include "server/device/embree/embree_raw.h"
#include "server/device/embree/embree_scene.h"
#include "server/request/frame_request.h"
#include "tests/support/bodies.h"

#include <gtest/gtest.h>
#include <malloc.h>
#include <pmmintrin.h>

#include <atomic>
#include <latch>
#include <thread>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

struct GivenUp {};  // no std::exception, as the scene cache's

/// A body by itself and another that stands twice.
std::shared_ptr<const Scene> twoBodies() {
    SceneBuilder builder("bodies");
    builder.addInstance(builder.addMesh(test::icosphere(6)), mat4(1.0f));
    const uint32_t twice = builder.addMesh(test::icosphere(6));
    for (float x : {3.0f, 6.0f}) {
        mat4 toWorld(1.0f);
        toWorld[3] = vec4(x, 0.0f, 0.0f, 1.0f);
        builder.addInstance(twice, toWorld);
    }
    return builder.finish();
}

/// Gives up at call number `last`.
Progress givingUpAt(std::atomic<int>& calls, int last) {
    return [&calls, last](const std::string&, double) {
        if (++calls == last) throw GivenUp();
    };
}

bool countBytes(void* sum, ssize_t bytes, bool) {
    *static_cast<std::atomic<int64_t>*>(sum) += bytes;
    return true;
}

TEST(EmbreeScene, WhatProgressThrowsComesOutAndNothingStays) {
    const EmbreeHandle<RTCDevice> device(rtcNewDevice("set_affinity=0"));
    std::atomic<int64_t> bytes{0};
    rtcSetDeviceMemoryMonitorFunction(device.get(), countBytes, &bytes);
    const auto scene = twoBodies();
    std::atomic<int> all{0};
    { EmbreeScene whole(device.get(), scene, 1, false, givingUpAt(all, -1)); }
    const int64_t before = bytes;
    ASSERT_GE(all, 6);
    for (int last : {1, 2, all / 2, all - 1}) {
        std::atomic<int> calls{0};
        EXPECT_THROW(EmbreeScene(device.get(), scene, 1, false, givingUpAt(calls, last)), GivenUp) << last << " of " << all;
        EXPECT_EQ(bytes, before) << last << " of " << all;
    }
    EXPECT_NO_THROW(EmbreeScene(device.get(), scene, 1, false, Progress{}));
}

TEST(EmbreeDevice, LoadsAgainAfterALoadWasGivenUp) {
    const std::unique_ptr<Device> device = makeEmbreeDevice();
    const auto scene = twoBodies();
    std::atomic<int> calls{0};
    EXPECT_THROW(device->load(scene, {}, givingUpAt(calls, 2)), GivenUp);
    EXPECT_NO_THROW(device->load(scene, {}, {}));
}

TEST(EmbreeDevice, LeavesTheCallersModeOfDenormalNumbersAlone) {
    const std::unique_ptr<Device> device = makeEmbreeDevice();
    const auto scene = twoBodies();
    device->load(scene, {}, {});
    FrameRequest request;
    request.camera = cameraFrom(scene->cameras.front());
    request.resolution = uvec2(32, 32);
    Tile tile;
    tile.size = request.resolution;
    const unsigned modes = _MM_FLUSH_ZERO_MASK | _MM_DENORMALS_ZERO_MASK;
    const unsigned before = _mm_getcsr() & modes;
    ASSERT_EQ(before, 0u);
    unsigned inside = 0;
    device->renderStream(request, {&tile, 1}, [&](TileResult&&) { inside = _mm_getcsr() & modes; }, {});
    EXPECT_EQ(inside, modes);
    EXPECT_EQ(_mm_getcsr() & modes, before);
}

TEST(EmbreeRaw, TheThreadThatBenchesCountsDenormalsAsBefore) {
    const std::shared_ptr<const Scene> scene = twoBodies();
    FrameRequest request;
    request.camera = cameraFrom(scene->cameras.front());
    request.resolution = uvec2(64, 64);
    const unsigned modes = _MM_FLUSH_ZERO_MASK | _MM_DENORMALS_ZERO_MASK;
    ASSERT_EQ(_mm_getcsr() & modes, 0u);
    EmbreeRaw raw;
    raw.prepare(scene, request);
    EXPECT_EQ(raw.trace(RayKind::primary).rays, 64u * 64u);
    EXPECT_EQ(_mm_getcsr() & modes, 0u);
}

/// Bytes in use of the whole process; 0 under sanitizers, whose heap says nothing.
uint64_t heapBytes() {
    const struct mallinfo2 info = mallinfo2();
    return info.uordblks + info.hblkhd;
}

// Each viewer's frames come from a thread of its own.
TEST(EmbreeDevice, KeepsNothingForEachThreadThatHasRendered) {
    const std::unique_ptr<Device> device = makeEmbreeDevice();
    const auto scene = twoBodies();
    device->load(scene, {}, {});
    FrameRequest request;
    request.camera = cameraFrom(scene->cameras.front());
    request.resolution = uvec2(32, 32);
    Tile tile;
    tile.size = request.resolution;
    constexpr int THREADS = 24;
    std::latch over(1);
    std::vector<std::jthread> threads;
    uint64_t first = 0;
    for (int i = 0; i < THREADS; i++) {
        std::latch rendered(1);
        threads.emplace_back([&] {
            device->render(request, {&tile, 1}, [](TileResult&&) {}, {});
            rendered.count_down();
            over.wait();
        });
        rendered.wait();
        if (i == 0) first = heapBytes();
    }
    EXPECT_LE(heapBytes(), first + THREADS * 40'000) << "a thread's own buffers are larger";
    over.count_down();
}

TEST(EmbreeDevice, RendersInEveryQualityThoughItKeepsAFewTrees) {
    const std::unique_ptr<Device> device = makeEmbreeDevice();
    const auto scene = twoBodies();
    Settings settings;
    device->load(scene, settings, {});
    FrameRequest request;
    request.camera = cameraFrom(scene->cameras.front());
    request.resolution = uvec2(32, 32);
    Tile tile;
    tile.size = request.resolution;
    for (int round = 0; round < 2; round++) {
        for (uint32_t i = 0; i < 6; i++) {
            request.settings.bvhQuality = i / 2;
            request.settings.robust = i % 2 == 1;
            int tiles = 0;
            device->render(request, {&tile, 1}, [&](TileResult&&) { tiles++; }, {});
            EXPECT_EQ(tiles, 1);
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

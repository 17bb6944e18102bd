#include "server/film/cell_bounces.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

FrameRequest requestOf(uvec2 size = uvec2(100, 60)) {
    FrameRequest request;
    request.resolution = size;
    return request;
}

Tile tileAt(uint32_t x, uint32_t y) { return {uvec2(x, y), uvec2(32), 0, 1, 1}; }

TileResult resultAt(uint32_t x, uint32_t y, uint64_t reflections, uint64_t refractions = 0) {
    TileResult result;
    result.tile = tileAt(x, y);
    result.rays[RayKind::primary] = 1024;
    result.rays[RayKind::reflection] = reflections;
    result.rays[RayKind::refraction] = refractions;
    return result;
}

TEST(CellBounces, KnowsWhichTilesSentNoPathOn) {
    CellBounces reach(uvec2(100, 60));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(0, 0))) << "nothing is known yet";
    reach.note(resultAt(0, 0, 0));
    reach.note(resultAt(32, 0, 3));
    reach.note(resultAt(64, 32, 0, 1));
    EXPECT_TRUE(reach.endsAtOnce(tileAt(0, 0)));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(32, 0)));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(64, 32)));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(96, 32))) << "nobody has been there";
}

TEST(CellBounces, OneSampleThatWentOnIsRemembered) {
    CellBounces reach(uvec2(100, 60));
    reach.note(resultAt(0, 0, 0));
    reach.note(resultAt(0, 0, 1));
    reach.note(resultAt(0, 0, 0));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(0, 0)));
}

TEST(CellBounces, TilesOutsideOfTheViewAreUnknown) {
    CellBounces reach(uvec2(33, 9));
    for (const uvec2 origin : {uvec2(40, 0), uvec2(0, 16), uvec2(4000, 4000)}) {
        reach.note(resultAt(origin.x, origin.y, 0));
        EXPECT_FALSE(reach.endsAtOnce(tileAt(origin.x, origin.y)));
    }
    reach.note(resultAt(32, 8, 0));
    EXPECT_TRUE(reach.endsAtOnce(tileAt(32, 8)));
}

/// Of a picture of 5 x 4 tiles whose tile in the middle of the left column went on.
std::shared_ptr<CellBounces> mirrorAtTheLeft(ViewBounces& reaches, const FrameRequest& request) {
    const auto reach = reaches.of(request);
    for (uint32_t y = 0; y < 128; y += 32)
        for (uint32_t x = 0; x < 160; x += 32) reach->note(resultAt(x, y, x == 0 && y == 64 ? 1 : 0));
    return reach;
}

TEST(ViewBounces, AfterASmallMoveTilesFarFromWhatWentOnAreGuessed) {
    ViewBounces reaches;
    FrameRequest request = requestOf(uvec2(160, 128));
    mirrorAtTheLeft(reaches, request);
    request.camera.position.x += 0.1f;
    const auto reach = reaches.of(request);
    for (uint32_t y = 0; y < 128; y += 32)
        for (uint32_t x = 0; x < 160; x += 32) EXPECT_EQ(reach->endsAtOnce(tileAt(x, y)), x > 32 || y < 32) << x << ' ' << y;
    // What is found out counts more than the guess, and guesses are no ground for others.
    reach->note(resultAt(96, 0, 2));
    EXPECT_FALSE(reach->endsAtOnce(tileAt(96, 0)));
    reach->note(resultAt(128, 96, 0));
    EXPECT_TRUE(reach->endsAtOnce(tileAt(128, 96)));
    request.camera.position.x += 0.1f;
    EXPECT_FALSE(reaches.of(request)->endsAtOnce(tileAt(64, 64))) << "it was never looked at";
}

TEST(ViewBounces, NothingIsGuessedAfterAJumpOrAnotherChange) {
    const FrameRequest first = requestOf(uvec2(160, 128));
    const auto guessedAfter = [&](auto change) {
        ViewBounces reaches;
        FrameRequest request = first;
        mirrorAtTheLeft(reaches, request);
        change(request);
        return reaches.of(request)->endsAtOnce(tileAt(128, 0));
    };
    EXPECT_TRUE(guessedAfter([](FrameRequest& r) { r.camera.position.y += 0.01f; }));
    EXPECT_TRUE(guessedAfter([](FrameRequest& r) { r.camera.forward = vec3(0.05f, 0, -1); }));
    EXPECT_FALSE(guessedAfter([](FrameRequest& r) { r.camera.forward = vec3(1, 0, 0); }));
    EXPECT_FALSE(guessedAfter([](FrameRequest& r) { r.camera.up = vec3(1, 0, 0); }));
    EXPECT_FALSE(guessedAfter([](FrameRequest& r) { r.camera.fieldOfView += 10.0f; }));
    EXPECT_FALSE(guessedAfter([](FrameRequest& r) { r.effects.bits ^= EFFECT_REFLECTIONS; }));
    EXPECT_FALSE(guessedAfter([](FrameRequest& r) { r.resolution = uvec2(161, 128); }));
}

TEST(ViewBounces, LastsUntilSomethingChanges) {
    ViewBounces reaches;
    const FrameRequest first = requestOf();
    const auto keptAfter = [&](const FrameRequest& second) {
        const auto before = reaches.of(first);
        return reaches.of(second) == before;
    };
    FrameRequest next = first;
    next.generation++;
    EXPECT_TRUE(keptAfter(next)) << "another pass of the same view";
    next = first;
    next.camera.position.x += 0.5f;
    EXPECT_FALSE(keptAfter(next));
    next = first;
    next.previousCamera = first.camera;
    EXPECT_FALSE(keptAfter(next));
    next = first;
    next.effects.bits ^= EFFECT_REFLECTIONS;
    EXPECT_FALSE(keptAfter(next));
    EXPECT_FALSE(keptAfter(requestOf(uvec2(101, 60))));
    const auto before = reaches.of(first);
    reaches.forget();
    EXPECT_NE(reaches.of(first), before) << "another scene";
}

TEST(ViewBounces, RemembersTheLatestSixteen) {
    ViewBounces reaches;
    FrameRequest request = requestOf(uvec2(64, 64));
    auto viewAt = [&](int i) {
        request.camera.position.x = static_cast<float>(i);
        return reaches.of(request);
    };
    const auto first = viewAt(0), second = viewAt(1);
    for (int i = 2; i < 16; i++) viewAt(i);
    EXPECT_EQ(viewAt(0), first) << "and it is the latest again";
    viewAt(16);
    EXPECT_EQ(viewAt(0), first);
    EXPECT_NE(viewAt(1), second);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

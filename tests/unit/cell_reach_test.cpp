#include "server/render/cell_reach.h"

#include <gtest/gtest.h>

namespace heliograph {
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

TEST(CellReach, KnowsWhichTilesSentNoPathOn) {
    CellReach reach(uvec2(100, 60));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(0, 0))) << "nothing is known yet";
    reach.note(resultAt(0, 0, 0));
    reach.note(resultAt(32, 0, 3));
    reach.note(resultAt(64, 32, 0, 1));
    EXPECT_TRUE(reach.endsAtOnce(tileAt(0, 0)));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(32, 0)));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(64, 32)));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(96, 32))) << "nobody has been there";
}

TEST(CellReach, OneSampleThatWentOnIsRemembered) {
    CellReach reach(uvec2(100, 60));
    reach.note(resultAt(0, 0, 0));
    reach.note(resultAt(0, 0, 1));
    reach.note(resultAt(0, 0, 0));
    EXPECT_FALSE(reach.endsAtOnce(tileAt(0, 0)));
}

TEST(CellReach, TilesOutsideOfTheViewAreUnknown) {
    CellReach reach(uvec2(33, 9));
    for (const uvec2 origin : {uvec2(40, 0), uvec2(0, 16), uvec2(4000, 4000)}) {
        reach.note(resultAt(origin.x, origin.y, 0));
        EXPECT_FALSE(reach.endsAtOnce(tileAt(origin.x, origin.y)));
    }
    reach.note(resultAt(32, 8, 0));
    EXPECT_TRUE(reach.endsAtOnce(tileAt(32, 8)));
}

TEST(ReachOfView, LastsUntilSomethingChanges) {
    ReachOfView reaches;
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

}  // namespace
}  // namespace heliograph

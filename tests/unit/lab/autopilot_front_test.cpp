#include "server/lab/live/autopilot_front.h"

#include "server/device/embree/embree_device.h"
#include "server/request/effect_rules.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

/// A flight in which most pictures are three steps down, on the last rung of what cornell can do without.
AutopilotFlight flightOf(const Scene& scene, const Settings& settings) {
    AutopilotFlight flight;
    flight.scene = scene.name;
    flight.resolution = uvec2(32, 18);
    flight.budget = 1e-3;
    flight.wholeSeconds = 4e-3;
    flight.rungs = ladderOf(settings, effectsOf(scene));
    const LadderChoice first{}, last{static_cast<uint32_t>(flight.rungs.size() - 1), 3, 0.0};
    for (const LadderChoice& at : {first, last, last, last}) flight.frames.push_back({1e-3, at});
    return flight;
}

// Whatever times are here: what is best for the time takes no longer, and is no worse.
TEST(AutopilotFront, SaysHowFarFromTheBestMostPicturesAre) {
    const auto device = makeEmbreeDevice();
    const auto scene = openScene("cornell");
    const Settings settings;
    test::DirectRenderer renderer(*device);
    renderer.load(scene, settings, {});
    const AutopilotFlight flight = flightOf(*scene, settings);
    ASSERT_GT(flight.rungs.size(), 2u);
    FrontBounds bounds;
    bounds.seconds = 1e-3;  // every point once
    bounds.references = 64;
    bounds.views = 1;
    bounds.repetitions = 1;
    const FrontPlace place = placeBesideFront(renderer, *scene, flight, bounds, {});
    EXPECT_DOUBLE_EQ(place.share, 0.75);
    EXPECT_THAT(place.set, testing::HasSubstr("renderScale="));
    EXPECT_GT(place.error, 0.02) << "two thirds of the pixels, three times over";
    EXPECT_GT(place.bestError, 0.0);
    EXPECT_LE(place.bestMs, place.ms);
    EXPECT_GE(place.ratio(), 1.0);
    AutopilotFlight told = flight;
    told.front = place;
    EXPECT_EQ(toJson({told})["flights"][0]["front"]["ratio"], place.ratio());
    EXPECT_TRUE(toJson({flight})["flights"][0]["front"].is_null());
    EXPECT_THAT(toTable({told}), testing::HasSubstr("best for the time"));
}

}  // namespace
}  // namespace heliograph::TEST_FILE

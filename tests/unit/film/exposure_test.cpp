#include "server/film/exposure.h"

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

/// A film of one sample, its pixels as `radiance(x, y)` says.
template <typename Radiance>
void expose(Film& film, uvec2 size, Radiance radiance) {
    film.reset(size, 1);
    TileResult result;
    result.tile = {{0, 0}, size, 0, 1, 1};
    for (uint32_t y = 0; y < size.y; y++)
        for (uint32_t x = 0; x < size.x; x++) result.radianceSum.push_back(vec4(radiance(x, y), 0.0f));
    ASSERT_TRUE(film.add(result));
}

TEST(Exposure, BringsAnEvenPictureToMidGrey) {
    Film film;
    for (const float radiance : {1e-4f, 0.18f, 3.0f, 5e4f}) {
        expose(film, {16, 16}, [&](uint32_t, uint32_t) { return vec3(radiance); });
        ASSERT_TRUE(meteredExposure(film));
        EXPECT_NEAR(*meteredExposure(film), std::log2(0.18f / radiance), 1e-3f) << radiance;
    }
}

TEST(Exposure, IsTheMeanOfLogarithms) {
    Film film;
    expose(film, {16, 16}, [](uint32_t x, uint32_t) { return vec3(x % 2 == 0 ? 0.5f : 8.0f); });
    EXPECT_NEAR(*meteredExposure(film), std::log2(0.18f / 2.0f), 0.02f);
}

TEST(Exposure, AFewLampsAndShadowsDoNotDecide) {
    Film film;
    expose(film, {20, 20}, [](uint32_t, uint32_t y) { return vec3(y == 0 ? 1e6f : y == 1 ? 1e-6f : 0.5f); });
    EXPECT_NEAR(*meteredExposure(film), std::log2(0.18f / 0.5f), 1e-3f);
}

TEST(Exposure, NeitherBlackNorTheBackdropCounts) {
    Film film;
    const vec3 backdrop(0.24f, 0.27f, 0.33f);
    expose(film, {16, 16}, [&](uint32_t x, uint32_t y) { return x < 3 ? vec3(40.0f) : y < 8 ? backdrop : vec3(0.0f); });
    EXPECT_NEAR(*meteredExposure(film, backdrop), std::log2(0.18f / 40.0f), 1e-3f);
    EXPECT_GT(*meteredExposure(film), *meteredExposure(film, backdrop) + 3.0f);
    expose(film, {8, 8}, [&](uint32_t x, uint32_t) { return x < 4 ? backdrop : vec3(0.0f); });
    EXPECT_FALSE(meteredExposure(film, backdrop));
}

TEST(Exposure, HasLimits) {
    Film film;
    expose(film, {8, 8}, [](uint32_t, uint32_t) { return vec3(1e30f); });
    EXPECT_EQ(*meteredExposure(film), LEAST_EXPOSURE);
    expose(film, {8, 8}, [](uint32_t, uint32_t) { return vec3(1e-30f); });
    EXPECT_EQ(*meteredExposure(film), MOST_EXPOSURE);
}

TEST(Exposure, ReadsSomeRowsOfALargePicture) {
    Film film;
    expose(film, {2048, 96}, [](uint32_t, uint32_t y) { return vec3(y < 48 ? 0.5f : 8.0f); });
    EXPECT_NEAR(*meteredExposure(film), std::log2(0.18f / 2.0f), 0.05f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

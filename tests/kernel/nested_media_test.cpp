// The set of bodies that a path carries, against a sorted list.

#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

uint32_t packed(std::vector<uint32_t> media) {
    std::ranges::sort(media, std::greater());
    uint32_t set = 0;
    for (size_t i = 0; i < media.size() && i < 4; i++) set |= media[i] << (7 * i);
    return set;
}

TEST(NestedMedia, EnteringAndLeavingIsThatOfASortedList) {
    EveryKernel kernel = bareKernel();
    Random random(21);
    for (int round = 0; round < 20000; round++) {
        std::vector<uint32_t> list;
        uint32_t set = 0;
        for (int step = 0; step < 12; step++) {
            const uint32_t medium = random.below(6) * 25 + 1;  // often the same
            if (list.size() < 4 && random.below(2) == 0) {
                list.push_back(medium);
                set = kernel.withMedium(set, medium);
            } else {
                const auto found = std::ranges::find(list, medium);
                EXPECT_EQ(kernel.isAmong(medium, set), found != list.end());
                if (found != list.end()) list.erase(found);
                set = kernel.withoutMedium(set, medium);
            }
            ASSERT_EQ(set, packed(list));
        }
    }
}

TEST(NestedMedia, OfFiveBodiesTheLowestIsGivenUp) {
    EveryKernel kernel = bareKernel();
    EXPECT_EQ(kernel.withMedium(packed({9, 7, 5, 3}), 6), packed({9, 7, 6, 5}));
    EXPECT_EQ(kernel.withMedium(packed({9, 7, 5, 3}), 1), packed({9, 7, 5, 3}));
    EXPECT_EQ(kernel.withMedium(packed({127, 127, 127, 127}), 127), packed({127, 127, 127, 127}));
}

/// Glass over water, and what a surface of either does to paths.
struct Vessel {
    EveryKernel kernel = bareKernel();
    std::vector<Material> materials{2};
    Vessel() {
        materials[0].medium = 2, materials[0].ior = 1.5f, materials[0].mediumMaterial = 1;
        materials[1].medium = 1, materials[1].ior = 1.33f, materials[1].mediumMaterial = 0;
        kernel.scene.materials = materials.data();
        kernel.frame.effects |= EFFECT_NESTED_MEDIA;
    }
    EveryKernel::Surface surface(uint32_t material, float side) const {
        EveryKernel::Surface s{};
        s.material = material;
        s.side = side;
        return s;
    }
};

constexpr uint32_t WATER = 1, GLASS = 2;

TEST(NestedMedia, TheIndexIsThatOfTheTwoSides) {
    Vessel v;
    const auto index = [&](uint32_t media, uint32_t material, float side) {
        const auto s = v.surface(material, side);
        return v.kernel.relativeIor(v.kernel.crossingAt(media, s), s);
    };
    EXPECT_EQ(index(0, 0, 1.0f), 1.5f) << "into glass from air";
    EXPECT_EQ(index(GLASS, 0, -1.0f), 1.5f) << "out of it";
    EXPECT_FLOAT_EQ(index(packed({GLASS, WATER}), 0, -1.0f), 1.5f / 1.33f) << "from the wall into the water";
    EXPECT_FLOAT_EQ(index(WATER, 0, 1.0f), 1.5f / 1.33f) << "and back";
    EXPECT_EQ(index(GLASS, 1, 1.0f), 1.0f) << "the water's side in the wall";
    EXPECT_EQ(index(0, 1, 1.0f), 1.33f) << "the water's top";
}

TEST(NestedMedia, SeamsAndFaultsAreTold) {
    Vessel v;
    const auto crossing = [&](uint32_t media, uint32_t material, float side) {
        return v.kernel.crossingAt(media, v.surface(material, side));
    };
    EXPECT_TRUE(crossing(GLASS, 1, 1.0f).seam);
    EXPECT_TRUE(crossing(packed({GLASS, WATER}), 1, -1.0f).seam);
    EXPECT_FALSE(crossing(WATER, 0, 1.0f).seam);
    EXPECT_EQ(crossing(GLASS, 0, -1.0f).lost, 0u);
    const auto stranger = crossing(0, 1, -1.0f);
    EXPECT_EQ(stranger.lost, EveryKernel::MEDIA_UNDERFLOW) << "a body that was never entered";
    EXPECT_EQ(stranger.before, WATER) << "it is taken to have been about the path";
    EXPECT_EQ(stranger.after, 0u);
    EXPECT_EQ(crossing(packed({2, 2, 2, 2}), 1, 1.0f).lost, EveryKernel::MEDIA_OVERFLOW);
    EXPECT_EQ(crossing(GLASS | 15u << 28, 1, 1.0f).lost, EveryKernel::MEDIA_OVERFLOW) << "fifteen seams in a row";
    EXPECT_EQ(crossing(GLASS | 14u << 28, 1, 1.0f).lost, 0u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

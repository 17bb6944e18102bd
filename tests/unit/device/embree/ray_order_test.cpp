#define HELIOGRAPH_KERNEL_NAMESPACE lanes_under_test

#include "server/device/embree/ray_order.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {
namespace {

void setDirection(std::vector<RTCRay16>& packets, uint32_t ray, vec3 direction) {
    packets[ray / PACKET].dir_x[ray % PACKET] = direction.x;
    packets[ray / PACKET].dir_y[ray % PACKET] = direction.y;
    packets[ray / PACKET].dir_z[ray % PACKET] = direction.z;
}

TEST(RayOrder, HasEveryRayOnceAndThoseOfADirectionTogether) {
    constexpr uint32_t COUNT = 1000;
    std::vector<RTCRay16> packets(COUNT / PACKET + 1);
    std::mt19937 random(7);
    std::vector<uint32_t> kinds(COUNT);
    const vec3 directions[] = {{1, 0, 0}, {-1, 0, 0}, {0, 0.8f, 0.6f}, {0, -0.8f, -0.6f}, {0.6f, 0.8f, 0}};
    for (uint32_t i = 0; i < COUNT; i++) {
        kinds[i] = random() % 5;
        setDirection(packets, i, directions[kinds[i]]);
    }
    RayOrder order;
    const uint16_t* sorted = order.sort(packets.data(), COUNT);
    std::vector<int> seen(COUNT);
    uint32_t changes = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        ASSERT_LT(sorted[i], COUNT);
        seen[sorted[i]]++;
        if (i == 0) continue;
        if (kinds[sorted[i]] != kinds[sorted[i - 1]]) changes++;
        else EXPECT_LT(sorted[i - 1], sorted[i]) << "not as they came";
    }
    EXPECT_EQ(seen, std::vector<int>(COUNT, 1));
    EXPECT_EQ(changes, 4u);
}

TEST(RayOrder, TakesDirectionsThatAreNone) {
    const float inf = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const vec3 directions[] = {{nan, nan, nan}, {inf, -inf, inf}, {1e30f, -1e30f, 0}, {-1, -1, -1}, {1, 1, 1}};
    std::vector<RTCRay16> packets(1);
    for (uint32_t i = 0; i < 5; i++) setDirection(packets, i, directions[i]);
    RayOrder order;
    const uint16_t* sorted = order.sort(packets.data(), 5);
    std::vector<int> seen(5);
    for (uint32_t i = 0; i < 5; i++) seen.at(sorted[i])++;
    EXPECT_EQ(seen, std::vector<int>(5, 1));
}

}  // namespace
}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

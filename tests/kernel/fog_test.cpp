// The way of rays through the ball of fog, in double: far off, along its rim and from inside.

#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

struct Way {
    double begin, length;
};

Way exactWay(dvec3 origin, dvec3 direction, dvec3 center, double radius) {
    const dvec3 d = glm::normalize(direction), o = origin - center;
    const double b = glm::dot(o, d), off = glm::length(o - d * b);
    if (off >= radius) return {0.0, 0.0};
    const double half = std::sqrt((radius - off) * (radius + off)), begin = std::max(-b - half, 0.0);
    return {begin, std::max(half - b - begin, 0.0)};
}

TEST(FogSpan, KeepsTheBallsDigitsFromFarAway) {
    EveryKernel kernel = bareKernel();
    kernel.frame.fogRadius = 1.0f;
    Random random(1);
    for (float far : {1e1f, 1e2f, 1e3f, 1e4f}) {
        for (int i = 0; i < 20000; i++) {
            kernel.frame.fogCenter = random.direction() * far;
            const vec3 d = kernel.normalize3(kernel.frame.fogCenter + random.inCube(0.55f));
            const vec2 span = kernel.fogSpan(vec3(0.0f), d, EveryKernel::FLOAT_MAX);
            const Way exact = exactWay(dvec3(0.0), dvec3(d), dvec3(kernel.frame.fogCenter), 1.0);
            ASSERT_NEAR(span.x, exact.begin, 1e-6 + 4e-7 * far) << far;
            ASSERT_NEAR(span.y, exact.length, 1e-6 + 4e-7 * far) << far;
        }
    }
}

TEST(FogSpan, FromInsideGoesToTheRim) {
    EveryKernel kernel = bareKernel();
    kernel.frame.fogCenter = vec3(1.0f, 2.0f, 3.0f);
    kernel.frame.fogRadius = 2.0f;
    Random random(2);
    for (int i = 0; i < 20000; i++) {
        const vec3 origin = kernel.frame.fogCenter + random.direction() * random.real(0.0f, 1.9f), d = random.direction();
        const vec2 span = kernel.fogSpan(origin, d, EveryKernel::FLOAT_MAX);
        ASSERT_EQ(span.x, 0.0f);
        ASSERT_NEAR(span.y, exactWay(dvec3(origin), dvec3(d), dvec3(kernel.frame.fogCenter), 2.0).length, 4e-6);
        ASSERT_FLOAT_EQ(kernel.fogSpan(origin, d, span.y * 0.5f).y, span.y * 0.5f) << "no farther than asked";
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

#include <bit>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

EveryKernel kernel = bareKernel();

TEST(KernelMath, ExpKernelIsRightTo3e7) {
    Random random(1);
    double worst = 0.0;
    for (int i = 0; i < 200000; i++) {
        const float x = i < 100000 ? random.real(-87.0f, 88.0f) : random.real(-2.0f, 2.0f);
        const double exact = std::exp(double(x));
        worst = std::max(worst, std::abs(kernel.expKernel(x) - exact) / exact);
    }
    EXPECT_LT(worst, 3e-7);
    EXPECT_EQ(kernel.expKernel(0.0f), 1.0f);
    EXPECT_EQ(kernel.expKernel(-1000.0f), kernel.expKernel(-87.0f)) << "clamped, not a denormal";
    EXPECT_EQ(kernel.expKernel(1000.0f), kernel.expKernel(88.0f));
    EXPECT_TRUE(std::isfinite(kernel.expKernel(88.0f)));
}

TEST(KernelMath, LogKernelIsRightTo2e7) {
    Random random(2);
    double worst = 0.0;
    for (int i = 0; i < 200000; i++) {
        const auto x = static_cast<float>(i < 100000 ? random.magnitude(1.2e-38, 3.3e38) : random.magnitude(0.25, 4.0));
        const double exact = std::log(double(x));
        worst = std::max(worst, std::abs(kernel.logKernel(x) - exact) / std::max(1.0, std::abs(exact)));
    }
    EXPECT_LT(worst, 2e-7);
    EXPECT_EQ(kernel.logKernel(1.0f), 0.0f);
}

TEST(KernelMath, Log2RoughIsRightTo1Percent) {
    Random random(3);
    double worst = 0.0;
    for (int i = 0; i < 100000; i++) {
        const auto x = static_cast<float>(random.magnitude(1e-30, 1e30));
        worst = std::max(worst, std::abs(kernel.log2Rough(x) - std::log2(double(x))));
    }
    EXPECT_LT(worst, 0.01);
    for (int n = -20; n <= 60; n++) EXPECT_EQ(kernel.log2Rough(std::ldexp(1.0f, n)), float(n)) << "powers of two are exact";
}

TEST(KernelMath, Exp2IntegerIsExact) {
    for (int n = -126; n <= 127; n++) EXPECT_EQ(kernel.exp2Integer(n), std::ldexp(1.0f, n));
}

// The logarithm's error is multiplied by y, so the bound grows with the exponent of the result.
TEST(KernelMath, PowKernelErrorGrowsWithTheExponentOnly) {
    Random random(4);
    double worst = 0.0;
    for (int i = 0; i < 100000; i++) {
        const float x = random.real(1e-6f, 1.0f);
        const auto y = static_cast<float>(random.magnitude(0.01, 2000.0));
        const double exponent = y * std::log(double(x));
        if (exponent < -80.0) continue;
        const double exact = std::exp(exponent);
        worst = std::max(worst, std::abs(kernel.powKernel(x, y) - exact) / exact / (1.0 + std::abs(exponent)));
    }
    EXPECT_LT(worst, 4e-7);
}

TEST(KernelMath, PowKernelAtItsEdges) {
    EXPECT_EQ(kernel.powKernel(0.0f, 0.0f), 1.0f);
    EXPECT_EQ(kernel.powKernel(0.0f, 2.0f), 0.0f);
    EXPECT_EQ(kernel.powKernel(1e-38f, 1.0f), 0.0f);
    EXPECT_EQ(kernel.powKernel(1.0f, 1e5f), 1.0f);
    EXPECT_EQ(kernel.powKernel(0.3f, 0.0f), 1.0f);
}

TEST(KernelMath, SinCosTurnIsRightTo2e7) {
    Random random(5);
    double worst = 0.0;
    for (int i = 0; i < 200000; i++) {
        const float turn = i < 64 ? float(i) / 64.0f : random.real(0.0f, 1.0f);
        float s, c;
        kernel.sinCosTurn(turn, s, c);
        worst = std::max({worst, std::abs(s - std::sin(2.0 * EXACT_PI * turn)), std::abs(c - std::cos(2.0 * EXACT_PI * turn))});
    }
    EXPECT_LT(worst, 2e-7);
}

TEST(KernelMath, SinCosTurnIsExactAtQuarterTurns) {
    const float sines[] = {0.0f, 1.0f, 0.0f, -1.0f};
    for (int i = 0; i < 4; i++) {
        float s, c;
        kernel.sinCosTurn(0.25f * float(i), s, c);
        EXPECT_EQ(s, sines[i]) << i;
        EXPECT_EQ(c, sines[(i + 1) % 4]) << i;
    }
}

TEST(KernelMath, AcosKernelIsRightTo5e7) {
    Random random(6);
    double worst = 0.0;
    for (int i = 0; i < 200000; i++) {
        const float x = i < 100000
                            ? random.real(-1.0f, 1.0f)
                            : std::copysign(1.0f - static_cast<float>(random.magnitude(1e-7, 1e-2)), random.real(-1.0f, 1.0f));
        worst = std::max(worst, std::abs(kernel.acosKernel(x) - std::acos(double(x))));
    }
    EXPECT_LT(worst, 5e-7);
    EXPECT_EQ(kernel.acosKernel(1.0f), 0.0f);
    EXPECT_EQ(kernel.acosKernel(-1.0f), EveryKernel::PI);
    EXPECT_EQ(kernel.acosKernel(1.0000001f), 0.0f) << "clamped: a unit vector may be a little longer";
    EXPECT_EQ(kernel.acosKernel(-1.0000001f), EveryKernel::PI);
}

TEST(KernelMath, Atan2KernelIsRightTo5e7) {
    Random random(7);
    double worst = 0.0;
    for (int i = 0; i < 200000; i++) {
        const double angle = random.number(-EXACT_PI, EXACT_PI), length = random.magnitude(1e-15, 1e15);
        const auto x = static_cast<float>(length * std::cos(angle)), y = static_cast<float>(length * std::sin(angle));
        worst = std::max(worst, std::abs(kernel.atan2Kernel(y, x) - std::atan2(double(y), double(x))));
    }
    EXPECT_LT(worst, 5e-7);
    EXPECT_EQ(kernel.atan2Kernel(0.0f, 0.0f), 0.0f);
    EXPECT_EQ(kernel.atan2Kernel(0.0f, 1.0f), 0.0f);
    EXPECT_FLOAT_EQ(kernel.atan2Kernel(0.0f, -1.0f), float(EXACT_PI));
    EXPECT_FLOAT_EQ(kernel.atan2Kernel(1.0f, 0.0f), float(EXACT_PI / 2));
    EXPECT_FLOAT_EQ(kernel.atan2Kernel(-1.0f, 0.0f), float(-EXACT_PI / 2));
}

TEST(KernelMath, Normalize3GivesUnitLengthAtAnyScale) {
    Random random(8);
    double worst = 0.0;
    for (int i = 0; i < 100000; i++) {
        const vec3 v = random.direction() * static_cast<float>(random.magnitude(1e-15, 1e18));
        worst = std::max(worst, std::abs(glm::length(dvec3(kernel.normalize3(v))) - 1.0));
    }
    EXPECT_LT(worst, 3e-7);
    EXPECT_EQ(kernel.normalize3(vec3(0.0f)), vec3(0.0f));
}

TEST(KernelMath, IsFinite3RefusesNanAndInfinityInAnyPlace) {
    EXPECT_TRUE(kernel.isFinite3(vec3(1.0f, -std::numeric_limits<float>::max(), 0.0f)));
    for (float bad : {NOT_A_NUMBER, INFINITE, -INFINITE}) {
        for (int i = 0; i < 3; i++) {
            vec3 v(1.0f);
            v[i] = bad;
            EXPECT_FALSE(kernel.isFinite3(v)) << i << ' ' << bad;
        }
    }
}

// Chi square with 255 degrees of freedom: mean 255, deviation 22.6. 370 is passed by chance once in about 10^6 tries.
TEST(KernelMath, HashesOfNeighboursFillAllBinsEvenly) {
    for (int shift : {0, 8, 16, 24}) {
        uint32_t bins[256] = {};
        for (uint32_t i = 0; i < 65536; i++) bins[kernel.hashUint(i) >> shift & 255u]++;
        double chi = 0.0;
        for (uint32_t n : bins) chi += (n - 256.0) * (n - 256.0) / 256.0;
        EXPECT_LT(chi, 370.0) << "bits from " << shift;
    }
    uint32_t bins[256] = {};
    for (uint32_t y = 0; y < 256; y++)
        for (uint32_t x = 0; x < 256; x++) bins[kernel.hashPixel(uvec2(x, y), 7u) >> 24]++;
    double chi = 0.0;
    for (uint32_t n : bins) chi += (n - 256.0) * (n - 256.0) / 256.0;
    EXPECT_LT(chi, 370.0) << "pixels";
}

TEST(KernelMath, EveryInputBitOfTheHashFlipsHalfOfTheOutput) {
    Random random(9);
    for (int in = 0; in < 32; in++) {
        double flips = 0.0;
        for (int i = 0; i < 4096; i++) {
            const uint32_t x = random.word();
            flips += std::popcount(kernel.hashUint(x) ^ kernel.hashUint(x ^ 1u << in));
        }
        EXPECT_NEAR(flips / 4096.0, 16.0, 0.3) << "bit " << in;  // deviation of the mean: 0.044
    }
}

TEST(KernelMath, UnitFloatNeverReachesOne) {
    EXPECT_EQ(kernel.unitFloat(0u), 0.0f);
    EXPECT_LT(kernel.unitFloat(0xffffffffu), 1.0f);
    EXPECT_EQ(kernel.unitFloat(0x80000000u), 0.5f);
}

TEST(KernelMath, OrthonormalBasisIsOne) {
    Random random(10);
    std::vector<vec3> normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {1e-4f, 0, -1}, {0, 1e-20f, -1}};
    for (int i = 0; i < 100000; i++) normals.push_back(random.direction());
    double worst = 0.0;
    for (vec3 n : normals) {
        vec3 t, b;
        kernel.orthonormalBasis(n, t, b);
        const dvec3 dn(n), dt(t), db(b);
        worst =
            std::max({worst, std::abs(glm::dot(dn, dt)), std::abs(glm::dot(dn, db)), std::abs(glm::dot(dt, db)),
                      std::abs(glm::length(dt) - 1.0), std::abs(glm::length(db) - 1.0), glm::length(glm::cross(dt, db) - dn)});
    }
    EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

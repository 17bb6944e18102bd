#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

#include <complex>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

EveryKernel kernel = bareKernel();

struct ExactFresnel {
    long double reflectance;
    long double cosT;
};

ExactFresnel exactFresnel(long double c, long double eta) {
    const long double radicand = 1.0L - eta * eta * (1.0L - c * c);
    if (radicand <= 0.0L) return {1.0L, 0.0L};
    const long double t = std::sqrt(radicand);
    const long double parallel = (c - eta * t) / (c + eta * t), perpendicular = (eta * c - t) / (eta * c + t);
    return {0.5L * (parallel * parallel + perpendicular * perpendicular), t};
}

TEST(Fresnel, DielectricMatchesLongDouble) {
    Random random(1);
    double worst = 0.0, worstCosine = 0.0;
    for (int i = 0; i < 200000; i++) {
        const float c = random.real(1e-3f, 1.0f), eta = random.real(0.3f, 3.0f);
        const ExactFresnel exact = exactFresnel(c, eta);
        float cosT;
        const float f = kernel.fresnelDielectric(c, eta, cosT);
        ASSERT_TRUE(f >= 0.0f && f <= 1.0f);
        if (exact.cosT < 0.02L) continue;  // near the critical angle: next test
        worst = std::max(worst, std::abs(double(f - exact.reflectance)));
        worstCosine = std::max(worstCosine, std::abs(double(cosT - exact.cosT)));
    }
    EXPECT_LT(worst, 5e-5);
    EXPECT_LT(worstCosine, 5e-5);
}

TEST(Fresnel, WellAwayFromTheCriticalAngleItIsRightTo1e6) {
    Random random(2);
    double worst = 0.0;
    for (int i = 0; i < 100000; i++) {
        const float c = random.real(0.05f, 1.0f), eta = random.real(0.4f, 1.0f);
        float cosT;
        worst = std::max(worst, std::abs(double(kernel.fresnelDielectric(c, eta, cosT) - exactFresnel(c, eta).reflectance)));
    }
    EXPECT_LT(worst, 1e-6);
}

// Glass to air, 100 steps of a microradian on both sides of asin(1/1.5). What float leaves of the radicand, about 1e-7, is
// amplified by 1 / (2 cosT); within a microradian of the edge by its square root.
TEST(Fresnel, TotalReflectionSetsInAtTheCriticalAngle) {
    const double critical = std::asin(1.0 / 1.5);
    double atEdge = 0.0, elsewhere = 0.0;
    for (int k = -100; k <= 100; k++) {
        const auto c = static_cast<float>(std::cos(critical + k * 1e-6));
        float cosT;
        const float f = kernel.fresnelDielectric(c, 1.5f, cosT);
        ASSERT_TRUE(std::isfinite(f) && std::isfinite(cosT));
        const ExactFresnel exact = exactFresnel(c, 1.5L);
        double& worst = exact.cosT < 2e-3L ? atEdge : elsewhere;
        worst = std::max(worst, std::abs(double(f - exact.reflectance)));
        if (k > 2) {
            EXPECT_EQ(f, 1.0f) << k;
            EXPECT_EQ(cosT, 0.0f) << k;
        }
    }
    EXPECT_LT(atEdge, 4e-3);
    EXPECT_LT(elsewhere, 2e-4);
}

TEST(Fresnel, NothingIsReflectedBetweenEqualIndices) {
    for (float c : {1.0f, 0.9f, 0.5f, 0.1f, 1e-3f, 1e-6f}) {
        float cosT;
        EXPECT_LT(kernel.fresnelDielectric(c, 1.0f, cosT), 1e-12f) << c;
        EXPECT_NEAR(cosT, c, 1e-7f * c) << "and nothing is bent";
    }
}

TEST(Fresnel, NormalIncidenceOnGlassIs4Percent) {
    float cosT;
    EXPECT_NEAR(kernel.fresnelDielectric(1.0f, 1.0f / 1.5f, cosT), 0.04f, 1e-7f);
    EXPECT_NEAR(kernel.fresnelDielectric(1.0f, 1.5f, cosT), 0.04f, 1e-7f);
}

TEST(Fresnel, GrazingIncidenceReflectsAll) {
    float cosT;
    EXPECT_NEAR(kernel.fresnelDielectric(0.0f, 1.0f / 1.5f, cosT), 1.0f, 1e-6f);
    EXPECT_EQ(kernel.fresnelDielectric(0.0f, 1.5f, cosT), 1.0f);
}

TEST(Fresnel, ExtremeIndicesStayFinite) {
    for (float eta : {1e-6f, 1e-3f, 0.9999999f, 1.0000001f, 1e3f, 1e6f}) {
        for (float c : {0.0f, 1e-20f, 1e-3f, 0.5f, 1.0f, 1.0000001f}) {
            float cosT;
            const float f = kernel.fresnelDielectric(c, eta, cosT);
            EXPECT_TRUE(f >= 0.0f && f <= 1.0f) << eta << ' ' << c;
            EXPECT_TRUE(cosT >= 0.0f && cosT <= 1.000001f) << eta << ' ' << c;
        }
    }
}

// The same reflectance from both sides of an interface at angles that belong together.
TEST(Fresnel, IsTheSameFromBothSides) {
    Random random(3);
    for (int i = 0; i < 10000; i++) {
        const float c = random.real(0.05f, 1.0f), eta = random.real(0.4f, 1.0f);
        float cosT, back;
        const float outside = kernel.fresnelDielectric(c, eta, cosT);
        EXPECT_NEAR(kernel.fresnelDielectric(cosT, 1.0f / eta, back), outside, 2e-5f);
        EXPECT_NEAR(back, c, 2e-5f);
    }
}

TEST(Fresnel, SchlickRunsFromF0ToWhite) {
    const vec3 f0(0.04f, 0.5f, 0.9f);
    EXPECT_EQ(kernel.fresnelSchlick(f0, 1.0f, 1.0f), f0);
    EXPECT_EQ(kernel.fresnelSchlick(f0, 1.0f, 0.0f), vec3(1.0f));
    for (float c = 0.0f; c <= 1.0f; c += 0.01f) {
        const double exact = 0.04 + 0.96 * std::pow(1.0 - c, 5.0);
        EXPECT_NEAR(kernel.fresnelSchlick(f0, 1.0f, c).x, exact, 3e-7);
    }
}

// Unpolarised, of a conductor. Born & Wolf, Principles of Optics (7th ed. 1999), 14.2.
double exactMetal(double c, double n, double k) {
    const std::complex<double> eta(n, k), t = std::sqrt(eta * eta - (1.0 - c * c));
    return 0.5 * (std::norm((c - t) / (c + t)) + std::norm((eta * eta * c - t) / (eta * eta * c + t)));
}

// What Schlick's formula is off by: of plastics and stones between 1.45 and 1.6, and of metals by their index at red (iron) or green.
TEST(Fresnel, SchlickLiesNearTheExactReflectance) {
    const auto worst = [](double f0, const auto& exact) {
        double most = 0.0;
        for (int i = 1; i <= 1000; i++) {
            const double c = i / 1000.0;
            most = std::max(most,
                            std::abs(kernel.fresnelSchlick(vec3(float(f0)), 1.0f, float(c)).x - static_cast<double>(exact(c))));
        }
        return most;
    };
    for (const auto& [ior, bound] : {std::pair(1.45, 0.040), {1.5, 0.036}, {1.6, 0.032}, {2.0, 0.045}, {2.4, 0.075}})
        EXPECT_NEAR(worst(std::pow((ior - 1) / (ior + 1), 2.0), [&](double c) { return exactFresnel(c, 1 / ior).reflectance; }),
                    bound, 0.001)
            << ior;
    struct Metal {
        const char* name;
        double n, k, bound;
    };
    for (const Metal& m : {Metal{"gold", 0.143, 3.983, 0.016},
                           {"silver", 0.155, 4.828, 0.018},
                           {"copper", 1.10, 2.44, 0.034},
                           {"aluminium", 1.10, 6.79, 0.102},
                           {"iron", 2.91, 3.09, 0.178}})
        EXPECT_NEAR(worst(exactMetal(1.0, m.n, m.k), [&](double c) { return exactMetal(c, m.n, m.k); }), m.bound, 0.001)
            << m.name;
}

TEST(Fresnel, KeepsItsDigitsAboutTheCriticalAngle) {
    EveryKernel k = bareKernel();
    for (double index : {1.1, 1.5, 2.4}) {
        const double critical = std::asin(1.0 / index);
        for (int i = -2000; i <= 2000; i++) {
            const auto cosI = static_cast<float>(std::cos(critical + i * 1e-7));
            const auto eta = static_cast<float>(index);
            float cosT = 0.0f;
            const float r = k.fresnelDielectric(cosI, eta, cosT);
            const long double e = eta, c = cosI, radicand = (1.0L - e) * (1.0L + e) + e * e * c * c;
            ASSERT_EQ(r == 1.0f, radicand <= 0.0L) << index << ' ' << i;
            ASSERT_NEAR(cosT, std::sqrt(std::max(radicand, 0.0L)), 2e-7) << index << ' ' << i;
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

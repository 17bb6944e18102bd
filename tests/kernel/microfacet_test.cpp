#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

EveryKernel kernel = bareKernel();

/// Radiance reflected towards `wo` under light of radiance 1 from everywhere. Half vectors are spread as the visible facets of
/// width `a` are (Heitz 2018), which `reflected(wi)` (radiance per irradiance, cosine included) is then divided by.
template <typename Reflected>
double directionalAlbedo(dvec3 wo, double a, const Reflected& reflected) {
    const int side = 150;
    const dvec3 stretched = glm::normalize(dvec3(a * wo.x, a * wo.y, wo.z));
    const dvec3 t1(0.0, 1.0, 0.0), t2 = glm::cross(stretched, t1);
    const double lean = 0.5 * (1.0 + stretched.z), a2 = a * a;
    double sum = 0.0;
    for (int i = 0; i < side; i++) {
        for (int j = 0; j < side; j++) {
            const double w = (i + 0.5) / side, r = std::sqrt(1.0 - w * w), turn = 2.0 * EXACT_PI * (j + 0.5) / side;
            const double p1 = r * std::cos(turn);
            const double p2 = (1.0 - lean) * std::sqrt(1.0 - p1 * p1) + lean * r * std::sin(turn);
            const dvec3 n = t1 * p1 + t2 * p2 + stretched * std::sqrt(std::max(1.0 - p1 * p1 - p2 * p2, 0.0));
            const dvec3 h = glm::normalize(dvec3(a * n.x, a * n.y, std::max(n.z, 1e-9)));
            const double woh = glm::dot(wo, h), d = 1.0 + (a2 - 1.0) * h.z * h.z;
            const dvec3 wi = 2.0 * woh * h - wo;
            if (woh <= 0.0 || wi.z <= 0.0) continue;
            const double seen = 2.0 / (wo.z + std::sqrt(a2 + (1.0 - a2) * wo.z * wo.z));  // G1 / cosine
            sum += 2.0 * w * reflected(wi) / (a2 / (EXACT_PI * d * d) * seen / 4.0);
        }
    }
    return sum / (side * side);
}

/// The same for functions that are smooth over the hemisphere.
template <typename Reflected>
double hemisphereAlbedo(const Reflected& reflected) {
    const int side = 300;
    double sum = 0.0;
    for (int i = 0; i < side; i++) {
        for (int j = 0; j < side; j++) {
            const double z = (i + 0.5) / side, turn = 2.0 * EXACT_PI * (j + 0.5) / side, r = std::sqrt(1.0 - z * z);
            sum += reflected(dvec3(r * std::cos(turn), r * std::sin(turn), z));
        }
    }
    return sum * 2.0 * EXACT_PI / (side * side);
}

dvec3 viewAt(double degrees) {
    const double angle = degrees * EXACT_PI / 180.0;
    return {std::sin(angle), 0.0, std::cos(angle)};
}

EveryKernel::Shading microfacetShading(float roughness, vec3 f0, vec3 diffuse) {
    EveryKernel::Shading m{};
    m.normal = vec3(0.0f, 0.0f, 1.0f);
    m.roughness = roughness;
    m.f0 = f0;
    m.f90 = kernel.grazingReflectance(f0);
    m.diffuse = diffuse;
    m.gain = vec3(1.0f);
    m.alpha = 1.0f;
    m.ior = 1.5f;
    return m;
}

double reflectedRed(const EveryKernel::Shading& m, dvec3 wo, dvec3 wi) {
    auto seen = m;
    kernel.seenFrom(seen, vec3(wo));
    return kernel.reflectedLight(seen, vec3(wo), vec3(wi)).x;
}

TEST(Microfacet, DistributionsProjectToOne) {
    for (double roughness : {0.1, 0.2, 0.4, 0.7, 1.0}) {
        const double a = roughness * roughness;
        // t in [0, 1) with cosine = 1 / sqrt(1 + a^2 t / (1 - t)), where the integrand is constant.
        double sum = 0.0;
        const int count = 20000;
        for (int i = 0; i < count; i++) {
            const double u = (i + 0.5) / count;
            const double cosine = std::sqrt((1.0 - u) / (1.0 + (a * a - 1.0) * u));
            const double d = 1.0 + (a * a - 1.0) * cosine * cosine;
            const double pdf = a * a * cosine / (EXACT_PI * d * d);  // of the direction whose cosine this is
            sum += kernel.distributionGgx(float(cosine), float(a)) * cosine / pdf;
        }
        EXPECT_NEAR(sum / count, 1.0, 2e-3) << "roughness " << roughness;
    }
}

TEST(Microfacet, VisibilityIsSmithsHeightCorrelatedOne) {
    Random random(1);
    const auto lambda = [](double c, double a) { return 0.5 * (std::sqrt(1.0 + a * a * (1.0 / (c * c) - 1.0)) - 1.0); };
    for (int i = 0; i < 20000; i++) {
        const float v = random.real(0.01f, 1.0f), l = random.real(0.01f, 1.0f), a = random.real(0.01f, 1.0f);
        const double exact = 1.0 / (1.0 + lambda(v, a) + lambda(l, a)) / (4.0 * v * l);
        ASSERT_NEAR(kernel.visibilityGgx(v, l, a) / exact, 1.0, 1e-5);
    }
}

// What bounces between facets is given back: white metal is white at every roughness and angle.
TEST(Microfacet, AWhiteMetalKeepsAllTheLight) {
    for (double roughness = 0.1; roughness < 1.05; roughness += 0.1) {
        for (double degrees : {0.0, 20.0, 40.0, 60.0, 75.0}) {
            const dvec3 wo = viewAt(degrees);
            const auto m = microfacetShading(float(roughness), vec3(1.0f), vec3(0.0f));
            const double albedo =
                directionalAlbedo(wo, roughness * roughness, [&](dvec3 wi) { return reflectedRed(m, wo, wi); });
            EXPECT_NEAR(albedo, 1.0, 1e-3) << "roughness " << roughness << " at " << degrees;
        }
    }
}

// At roughness 1 the distribution is 1 / pi and the albedo of one reflection at normal incidence the integral of
// c / (1 + c): 1 - ln 2.
TEST(Microfacet, RoughestAlbedoIsTheAnalyticOne) {
    const vec2 lobe = kernel.lobeIntegrals(1.0f, 1.0f);
    EXPECT_NEAR(lobe.x + lobe.y, 1.0 - std::log(2.0), 2e-4);
}

// The table between its nodes against quadrature of the kernel's own lobe.
TEST(Microfacet, LobeIntegralsAreThoseOfTheLobe) {
    for (double roughness : {0.15, 0.37, 0.61, 0.83}) {
        for (double degrees : {0.0, 33.0, 57.0, 76.0}) {
            const dvec3 wo = viewAt(degrees);
            for (float f0 : {0.04f, 0.5f, 1.0f}) {
                const auto m = microfacetShading(float(roughness), vec3(f0), vec3(0.0f));
                const double exact = directionalAlbedo(wo, roughness * roughness, [&](dvec3 wi) {
                    return double(kernel.reflectedLight(m, vec3(wo), vec3(wi)).x);  // without the gain
                });
                const vec2 lobe = kernel.lobeIntegrals(float(roughness), float(wo.z));
                EXPECT_NEAR(f0 * lobe.x + m.f90 * lobe.y, exact, 1.5e-3) << roughness << ' ' << degrees << ' ' << f0;
            }
        }
    }
}

TEST(Microfacet, AWhiteDielectricKeepsAllTheLight) {
    for (float roughness : {0.1f, 0.2f, 0.3f, 0.5f, 0.8f, 1.0f}) {
        for (double degrees : {0.0, 30.0, 60.0, 80.0}) {
            const dvec3 wo = viewAt(degrees);
            const auto m = microfacetShading(roughness, vec3(0.04f), vec3(1.0f));
            auto bare = m;
            bare.diffuse = vec3(0.0f);
            const double lobe =
                directionalAlbedo(wo, roughness * roughness, [&](dvec3 wi) { return reflectedRed(bare, wo, wi); });
            const double rest =
                hemisphereAlbedo([&](dvec3 wi) { return reflectedRed(m, wo, wi) - reflectedRed(bare, wo, wi); });
            EXPECT_NEAR(lobe + rest, 1.0, 3e-3) << roughness << " at " << degrees;
        }
    }
}

// Under light from the side the base of a smooth plastic keeps nearly all of a matt one's light: appendix B of glTF 2.0 gives 0.96
// of Lambert where n.l is 0.1.
TEST(Microfacet, PlasticKeepsItsDiffuseLightUnderFlatLight) {
    for (float roughness : {0.05f, 0.3f, 0.6f}) {
        const auto m = microfacetShading(roughness, vec3(0.04f), vec3(1.0f));
        auto bare = m;
        bare.diffuse = vec3(0.0f);
        const dvec3 wo = viewAt(10.0), wi = viewAt(-84.26);  // n.l 0.1
        const double diffuse = reflectedRed(m, wo, wi) - reflectedRed(bare, wo, wi);
        EXPECT_NEAR(diffuse * EXACT_PI / wi.z, 0.96, 0.02) << roughness;
    }
}

TEST(Microfacet, PhongDiffuseHasItsAlbedo) {
    auto m = microfacetShading(1.0f, vec3(0.0f), vec3(0.7f));
    m.flags = MATERIAL_PHONG;
    EXPECT_NEAR(hemisphereAlbedo([&](dvec3 wi) { return reflectedRed(m, viewAt(30.0), wi); }), 0.7, 1e-4);
}

TEST(Microfacet, PhongLobeIsTheCosineToItsExponent) {
    auto m = microfacetShading(1.0f, vec3(0.5f), vec3(0.0f));
    m.flags = MATERIAL_PHONG;
    m.exponent = 40.0f;
    for (double off : {0.0, 5.0, 15.0}) {
        const double expected = 0.5 / EXACT_PI * std::pow(std::cos(off * EXACT_PI / 180.0), 40.0);
        const dvec3 wi = viewAt(-30.0), wo = viewAt(30.0 + off);
        EXPECT_NEAR(reflectedRed(m, wo, wi), expected, 1e-5) << off;
    }
    m.exponent = 0.0f;
    EXPECT_EQ(reflectedRed(m, viewAt(30.0), viewAt(-30.0)), 0.0) << "no exponent, no highlight";
}

TEST(Microfacet, LightFromBehindGivesNothing) {
    for (uint32_t flags : {0u, uint32_t(MATERIAL_PHONG)}) {
        auto m = microfacetShading(0.5f, vec3(0.5f), vec3(0.5f));
        m.flags = flags;
        m.exponent = 20.0f;
        EXPECT_EQ(reflectedRed(m, viewAt(30.0), viewAt(100.0)), 0.0);
        EXPECT_EQ(reflectedRed(m, viewAt(30.0), viewAt(180.0)), 0.0);
    }
}

TEST(Microfacet, ASmoothMirrorHasAFiniteHighlight) {
    const auto m = microfacetShading(0.0f, vec3(1.0f), vec3(0.0f));
    const double peak = reflectedRed(m, viewAt(30.0), viewAt(-30.0));
    EXPECT_GT(peak, 1e3);
    EXPECT_TRUE(std::isfinite(peak));
    EXPECT_TRUE(std::isfinite(reflectedRed(m, viewAt(90.0), viewAt(-90.0))));
    EXPECT_TRUE(std::isfinite(reflectedRed(m, viewAt(10.0), viewAt(-170.0)))) << "half vector of length 0";
}

TEST(Microfacet, TraceableShareRunsFromMirrorToRough) {
    EXPECT_EQ(kernel.traceableShare(0.0f), 1.0f);
    EXPECT_EQ(kernel.traceableShare(0.2f), 1.0f);
    EXPECT_NEAR(kernel.traceableShare(0.3f), 0.5f, 1e-5f);
    EXPECT_EQ(kernel.traceableShare(0.4f), 0.0f);
    EXPECT_EQ(kernel.traceableShare(1.0f), 0.0f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

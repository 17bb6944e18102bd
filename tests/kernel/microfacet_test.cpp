#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

namespace heliograph {
namespace {

using namespace test;

EveryKernel kernel = bareKernel();

/// Radiance reflected towards `wo` under light of radiance 1 from everywhere: half vectors are spread as the distribution
/// of width `a` has them, which `reflected(wi)` (radiance per irradiance, cosine included) is then divided by.
template <typename Reflected>
double directionalAlbedo(dvec3 wo, double a, const Reflected& reflected) {
    const int side = 200;
    double sum = 0.0;
    for (int i = 0; i < side; i++) {
        for (int j = 0; j < side; j++) {
            const double u = (i + 0.5) / side, turn = 2.0 * EXACT_PI * (j + 0.5) / side;
            const double cosine = std::sqrt((1.0 - u) / (1.0 + (a * a - 1.0) * u)), sine = std::sqrt(1.0 - cosine * cosine);
            const dvec3 h(sine * std::cos(turn), sine * std::sin(turn), cosine);
            const double woh = glm::dot(wo, h);
            const dvec3 wi = 2.0 * woh * h - wo;
            if (woh <= 0.0 || wi.z <= 0.0) continue;
            const double d = 1.0 + (a * a - 1.0) * cosine * cosine;
            const double pdf = a * a * cosine / (EXACT_PI * d * d) / (4.0 * woh);
            sum += reflected(wi) / pdf;
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
    m.diffuse = diffuse;
    m.alpha = 1.0f;
    m.ior = 1.5f;
    return m;
}

double reflectedRed(const EveryKernel::Shading& m, dvec3 wo, dvec3 wi) {
    return kernel.reflectedLight(m, vec3(wo), vec3(wi)).x;
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

TEST(Microfacet, WhiteFurnaceNeverGainsEnergy) {
    for (double roughness = 0.1; roughness < 1.05; roughness += 0.1) {
        for (double degrees : {0.0, 20.0, 40.0, 60.0, 75.0, 85.0, 89.0}) {
            const dvec3 wo = viewAt(degrees);
            const auto m = microfacetShading(float(roughness), vec3(1.0f), vec3(0.0f));
            const double albedo =
                directionalAlbedo(wo, roughness * roughness, [&](dvec3 wi) { return reflectedRed(m, wo, wi); });
            EXPECT_LE(albedo, 1.001) << "roughness " << roughness << " at " << degrees;
            // Single scattering loses what is reflected a second time, more the rougher: down to 1 - ln 2 at roughness 1.
            EXPECT_GE(albedo, roughness < 0.35 ? 0.87 : 0.30) << "roughness " << roughness << " at " << degrees;
        }
    }
}

// At roughness 1 the distribution is 1 / pi and the albedo at normal incidence the integral of c / (1 + c): 1 - ln 2.
TEST(Microfacet, RoughestAlbedoIsTheAnalyticOne) {
    const auto m = microfacetShading(1.0f, vec3(1.0f), vec3(0.0f));
    const double albedo = hemisphereAlbedo([&](dvec3 wi) { return reflectedRed(m, viewAt(0.0), wi); });
    EXPECT_NEAR(albedo, 1.0 - std::log(2.0), 1e-4);
}

TEST(Microfacet, AWhiteDielectricGainsNoEnergy) {
    for (float roughness : {0.1f, 0.2f, 0.3f, 0.5f, 0.8f, 1.0f}) {
        for (double degrees : {0.0, 30.0, 60.0, 80.0, 85.0, 88.0}) {
            const dvec3 wo = viewAt(degrees);
            const auto m = microfacetShading(roughness, vec3(0.04f), vec3(1.0f));
            auto specular = m;
            specular.diffuse = vec3(0.0f);
            const double lobe =
                directionalAlbedo(wo, roughness * roughness, [&](dvec3 wi) { return reflectedRed(specular, wo, wi); });
            const double rest =
                hemisphereAlbedo([&](dvec3 wi) { return reflectedRed(m, wo, wi) - reflectedRed(specular, wo, wi); });
            EXPECT_LE(lobe + rest, 1.01) << roughness << " at " << degrees;
            EXPECT_GE(lobe + rest, 0.80) << roughness << " at " << degrees;
        }
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

// Against quadrature of the kernel's own lobe: the fit that ambient light uses. It was made for a lobe that loses less when
// rough, so white metals come out brighter, nearer to what reflects more than once.
TEST(Microfacet, EnvironmentBrdfIsNearTheLobesAlbedo) {
    double worst = 0.0, dielectric = 0.0;
    for (double roughness : {0.2, 0.4, 0.6, 0.8, 1.0}) {
        for (double degrees : {0.0, 30.0, 60.0, 75.0}) {
            const dvec3 wo = viewAt(degrees);
            for (float f0 : {0.04f, 0.5f, 1.0f}) {
                const auto m = microfacetShading(float(roughness), vec3(f0), vec3(0.0f));
                const double exact =
                    directionalAlbedo(wo, roughness * roughness, [&](dvec3 wi) { return reflectedRed(m, wo, wi); });
                const double fit = kernel.environmentBrdf(vec3(f0), float(roughness), float(wo.z)).x;
                worst = std::max(worst, std::abs(fit - exact));
                if (f0 < 0.1f) dielectric = std::max(dielectric, std::abs(fit - exact));
                EXPECT_TRUE(fit >= 0.0 && fit <= 1.0) << fit << " at " << roughness << ' ' << degrees << ' ' << f0;
            }
        }
    }
    EXPECT_LT(worst, 0.19);
    EXPECT_LT(dielectric, 0.06);
}

TEST(Microfacet, TraceableShareRunsFromMirrorToRough) {
    EXPECT_EQ(kernel.traceableShare(0.0f), 1.0f);
    EXPECT_EQ(kernel.traceableShare(0.2f), 1.0f);
    EXPECT_NEAR(kernel.traceableShare(0.3f), 0.5f, 1e-5f);
    EXPECT_EQ(kernel.traceableShare(0.4f), 0.0f);
    EXPECT_EQ(kernel.traceableShare(1.0f), 0.0f);
}

}  // namespace
}  // namespace heliograph

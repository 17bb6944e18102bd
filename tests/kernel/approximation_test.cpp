// Errors of what docs/reference/accuracy.md lists, where a closed form says how large they are.

#include "tests/kernel/kernel_access.h"

#include <gtest/gtest.h>

#include <bit>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

constexpr double DEGREE = 3.14159265358979323846 / 180.0;

// Rays into the hemisphere about a smooth normal that lie below the facet are mirrored above it: what they find counts twice. Of a
// cosine's hemisphere whose axis is tilted by t the share below is (1 - cos t) / 2.
TEST(Occlusion, AsManyRaysAreMirroredAsLieBelowTheFacet) {
    EveryKernel kernel = bareKernel();
    Random random(5);
    for (double degrees : {2.0, 10.0, 20.0, 30.0, 45.0}) {
        const vec3 normal(0, 1, 0);
        const vec3 facet(static_cast<float>(std::sin(degrees * DEGREE)), static_cast<float>(std::cos(degrees * DEGREE)), 0);
        vec3 tangent, bitangent;
        kernel.orthonormalBasis(normal, tangent, bitangent);
        constexpr int RAYS = 200'000;
        int below = 0;
        for (int i = 0; i < RAYS; i++) {
            const uvec2 point(random.word(), random.word());
            const vec3 plain = kernel.occlusionDirection(point, 0, normal, normal, tangent, bitangent);
            const vec3 sent = kernel.occlusionDirection(point, 0, normal, facet, tangent, bitangent);
            below += glm::dot(plain, facet) < 0.0f;
            ASSERT_GE(glm::dot(sent, facet), -1e-6f);
        }
        EXPECT_NEAR(double(below) / RAYS, (1.0 - std::cos(degrees * DEGREE)) / 2.0, 0.002) << degrees << " degrees";
    }
}

/// By how much a prism of 60 degrees turns light that comes in at this angle, in degrees.
double turnOfPrism(double ior, double incidence) {
    const double first = std::asin(std::sin(incidence) / ior);
    return (incidence + std::asin(ior * std::sin(60.0 * DEGREE - first)) - 60.0 * DEGREE) / DEGREE;
}

// Three colours stand for all between the ends of the spectrum: what lies between two of them is a quarter of the spectrum's width
// from the nearer one at most.
TEST(Dispersion, NoColourIsFartherThanAQuarterOfTheSpectrumFromOneOfTheThree) {
    EveryKernel kernel = bareKernel();
    kernel.frame.effects |= EFFECT_DISPERSION;
    constexpr float IOR = 1.5f, ABBE = 30.0f;
    std::vector<uint32_t> words(64, 0);
    Material material{};
    material.layers = 1;
    material.ior = IOR;
    material.flags = MATERIAL_VOLUME;
    words[material.layers + LAYER_dispersion] = std::bit_cast<uint32_t>(20.0f / ABBE);
    kernel.scene.materials = &material;
    kernel.scene.texels = words.data();
    double turns[3];
    const double incidence = std::asin(IOR * std::sin(30.0 * DEGREE));  // the middle colour passes evenly
    for (uint32_t channel = 0; channel < 3; channel++) {
        EveryKernel::Surface surface{};
        EveryKernel::Shading shading{};
        shading.flags = MATERIAL_VOLUME;
        shading.transmission = 1.0f;
        shading.ior = IOR;
        kernel.disperse(shading, surface, channel);
        turns[channel] = turnOfPrism(double(shading.ior), incidence);
    }
    const double width = turns[2] - turns[0];
    EXPECT_NEAR(width, 2.0 * std::sin(30.0 * DEGREE) / std::cos(incidence) * (0.5 / 30.0) / DEGREE, 0.01)
        << "(ior - 1) / V from end to end";
    double worst = 0.0;
    for (int i = 0; i <= 1000; i++) {
        const double turn = turns[0] + width * i / 1000.0;
        double nearest = 360.0;
        for (double own : turns) nearest = std::min(nearest, std::abs(turn - own));
        worst = std::max(worst, nearest);
    }
    EXPECT_NEAR(worst / width, 0.25, 0.01);
    EXPECT_NEAR(worst, 0.36, 0.01) << "degrees";
}

// What a convex mirror of radius R shows, seen from d away and itself t away, is spread 1 + 2 d t / (R (d + t)) times as wide as the
// cone that goes on unchanged from it: so much too fine are textures in it.
TEST(Cones, GoOnFromABallAsFromAPlane) {
    EveryKernel kernel = bareKernel();
    EveryKernel::PathState path{};
    path.direction = vec3(0, 0, -1);
    path.coneSpread = 1e-3f;
    EveryKernel::Surface surface{};
    surface.distance = 4.0f;
    surface.geometricNormal = vec3(0, 0, 1);
    const EveryKernel::PathState next = kernel.continuedPath(path, surface, vec3(0, 0, 1), vec3(1.0f), 1.0f, 0);
    EXPECT_EQ(next.coneSpread, path.coneSpread);
    EXPECT_EQ(next.coneWidth, 4e-3f);
    for (const auto& [radius, away, beyond] : {std::tuple(0.5, 4.0, 4.0), {2.0, 3.0, 10.0}, {10.0, 5.0, 1.0}}) {
        // Two rays a small angle apart, reflected by a ball that the first one meets head-on.
        const double angle = 1e-5, height = away * std::tan(angle);
        const double tilt = std::asin(height / radius);
        const double apart = height + beyond * std::tan(angle + 2.0 * tilt);
        const double cone = angle * (away + beyond);
        EXPECT_NEAR(apart / cone, 1.0 + 2.0 * away * beyond / (radius * (away + beyond)), 1e-3);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "tests/kernel/kernel_access.h"

#include "server/scene/kernel_tables.h"
#include "tests/support/bodies.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using Path = EveryKernel::PathState;

/// A white sky and one material, for stages that need no geometry.
struct Bench {
    Material material = SceneBuilder::defaultMaterial();
    Environment environment{};
    EveryKernel kernel = bareKernel();

    Bench() {
        environment.image = NO_INDEX;
        environment.color = environment.ambient[0] = vec4(1.0f, 1.0f, 1.0f, 0.0f);
        kernel.frame.effects =
            EFFECT_REFLECTIONS | EFFECT_REFRACTIONS | EFFECT_ABSORPTION | EFFECT_EMISSION | EFFECT_ALPHA_BLEND;
        kernel.frame.maxReflections = 4;
        kernel.frame.maxRefractions = 4;
    }
    Bench(const Bench&) = delete;

    void connect() {
        kernel.scene.materials = &material;
        kernel.scene.environment = &environment;
    }
};

/// A point at the origin whose facet faces +z, seen under `cosine`.
EveryKernel::Surface flatSurface(float side) {
    EveryKernel::Surface s{};
    s.clearance = 1e-6f;
    s.geometricNormal = s.normal = vec3(0, 0, 1);
    s.side = side;
    s.distance = 2.0f;
    s.color = vec4(1.0f);
    return s;
}

Path pathUnder(float cosine) {
    Path p{};
    p.direction = vec3(std::sqrt(1.0f - cosine * cosine), 0.0f, -cosine);
    p.throughput = vec3(1.0f);
    return p;
}

struct Followed {
    vec3 ended{0.0f};  // estimates
    vec3 weights{0.0f};
    uint32_t kinds = 0;
    Path reflection{}, refraction{}, pass{};
};

Followed follow(Bench& bench, const EveryKernel::Surface& s, const Path& p) {
    bench.connect();
    Followed f;
    auto m = bench.kernel.shadingAt(s);
    bench.kernel.seenFrom(m, -p.direction);
    f.kinds = bench.kernel.nextRays(p, s, m, p.throughput, f.reflection, f.refraction, f.pass, f.ended);
    if (f.kinds & EveryKernel::NEXT_REFLECTION) f.weights += f.reflection.throughput;
    if (f.kinds & EveryKernel::NEXT_REFRACTION) f.weights += f.refraction.throughput;
    if (f.kinds & EveryKernel::NEXT_PASS) f.weights += f.pass.throughput;
    return f;
}

void randomMaterial(Random& random, Material& m) {
    m = SceneBuilder::defaultMaterial();
    m.baseColor = vec4(1.0f);
    if (random.below(2))
        m.flags |= MATERIAL_PHONG, m.specular = vec4(0.0f), m.mirror = random.below(2) ? random.real(0.0f, 1.0f) : 0.0f;
    if (random.below(2)) m.flags |= MATERIAL_VOLUME;
    if (random.below(3) == 0) m.flags |= MATERIAL_ALPHA_BLEND, m.baseColor.w = random.real(0.0f, 1.0f);
    m.metallic = random.below(2) ? random.real(0.0f, 1.0f) : 0.0f;
    m.roughness = random.real(0.0f, 1.0f);
    m.transmission = random.below(2) ? random.real(0.0f, 1.0f) : float(random.below(2));
    const float indices[] = {0.0f, 0.5f, 1.0f, 1.0000001f, 1.33f, 1.5f, 2.4f, 1e6f};
    m.ior = indices[random.below(8)];
}

// Under a sky of radiance 1, what a white surface reflects, transmits and scatters of the ambient light sums to no more than 1.
TEST(Whitted, NoMaterialGainsEnergyUnderAConstantSky) {
    Random random(1);
    Bench bench;
    for (int i = 0; i < 100000; i++) {
        randomMaterial(random, bench.material);
        const auto s = flatSurface(random.below(2) ? 1.0f : -1.0f);
        const Path p = pathUnder(random.real(0.0f, 1.0f));
        const Followed f = follow(bench, s, p);
        auto m = bench.kernel.shadingAt(s);
        bench.kernel.seenFrom(m, -p.direction);
        const vec3 total = f.ended + f.weights + bench.kernel.ambientContribution(m, -p.direction, vec3(1.0f));
        ASSERT_TRUE(bench.kernel.isFinite3(total));
        ASSERT_LE(bench.kernel.maxComponent(total), 1.0f + 1e-3f)
            << "flags " << bench.material.flags << " metallic " << bench.material.metallic << " roughness "
            << bench.material.roughness << " transmission " << bench.material.transmission << " ior " << bench.material.ior
            << " mirror " << bench.material.mirror;
        ASSERT_GE(total.x, 0.0f);
    }
}

// Clear glass: reflected and transmitted parts are all there is. R + T = 1 for every index and angle, also at and beyond
// the critical one.
TEST(Whitted, ClearGlassPassesOnAllTheLight) {
    Bench bench;
    bench.material.transmission = 1.0f;
    bench.material.roughness = 0.0f;
    for (uint32_t flags : {0u, uint32_t(MATERIAL_VOLUME)}) {
        for (float ior : {0.5f, 1.0f, 1.0000001f, 1.33f, 1.5f, 2.4f, 1e6f, 0.0f}) {
            for (float side : {1.0f, -1.0f}) {
                for (float cosine = 0.0f; cosine <= 1.0f; cosine += 0.003f) {
                    bench.material.flags = flags;
                    bench.material.ior = ior;
                    const Followed f = follow(bench, flatSurface(side), pathUnder(cosine));
                    ASSERT_NEAR(f.weights.x + f.ended.x, 1.0f, 1e-6f)
                        << "ior " << ior << " cosine " << cosine << " side " << side;
                }
            }
        }
    }
}

TEST(Whitted, WhatIsNotFollowedIsEstimatedNeverLost) {
    Random random(2);
    Bench bench;
    for (int i = 0; i < 20000; i++) {
        randomMaterial(random, bench.material);
        const auto s = flatSurface(random.below(2) ? 1.0f : -1.0f);
        Path p = pathUnder(random.real(0.0f, 1.0f));
        const Followed all = follow(bench, s, p);
        const vec3 expected = all.ended + all.weights;
        p.depth = 4u | 4u << 8 | 16u << 16;  // every limit is reached
        const Followed none = follow(bench, s, p);
        ASSERT_EQ(none.kinds, 0u);
        ASSERT_NEAR(none.ended.x, expected.x, 1e-6f);
        p.depth = 0;
        bench.kernel.frame.contributionThreshold = 10.0f;
        const Followed faint = follow(bench, s, p);
        ASSERT_EQ(faint.kinds, 0u);
        ASSERT_NEAR(faint.ended.x, expected.x, 1e-6f);
        bench.kernel.frame.contributionThreshold = 0.0f;
    }
}

TEST(Whitted, DepthLimitsCountReflectionsAndRefractionsApart) {
    Bench bench;
    bench.material.transmission = 1.0f;
    bench.material.flags = MATERIAL_VOLUME;
    Path p = pathUnder(0.8f);
    p.depth = 4u;  // reflections at their limit of 4
    EXPECT_EQ(follow(bench, flatSurface(1.0f), p).kinds, uint32_t(EveryKernel::NEXT_REFRACTION));
    p.depth = 4u << 8;
    EXPECT_EQ(follow(bench, flatSurface(1.0f), p).kinds, uint32_t(EveryKernel::NEXT_REFLECTION));
    p.depth = 2u | 3u << 8;
    const Followed f = follow(bench, flatSurface(1.0f), p);
    EXPECT_EQ(bench.kernel.reflectionDepth(f.reflection.depth), 3u);
    EXPECT_EQ(bench.kernel.refractionDepth(f.reflection.depth), 3u);
    EXPECT_EQ(bench.kernel.reflectionDepth(f.refraction.depth), 2u);
    EXPECT_EQ(bench.kernel.refractionDepth(f.refraction.depth), 4u);
    EXPECT_EQ(bench.kernel.rayKindOf(f.reflection.depth), uint32_t(EveryKernel::RAY_REFLECTION));
    EXPECT_EQ(bench.kernel.rayKindOf(f.refraction.depth), uint32_t(EveryKernel::RAY_REFRACTION));
}

TEST(Whitted, RefractedRaysFollowSnell) {
    Bench bench;
    bench.material.transmission = 1.0f;
    bench.material.flags = MATERIAL_VOLUME;
    Random random(3);
    for (int i = 0; i < 20000; i++) {
        const float ior = random.real(1.0f, 2.5f), cosine = random.real(0.02f, 1.0f);
        bench.material.ior = ior;
        const bool enters = random.below(2) != 0;
        const Path p = pathUnder(cosine);
        const Followed f = follow(bench, flatSurface(enters ? 1.0f : -1.0f), p);
        const double sine = std::sqrt(1.0 - double(cosine) * cosine) * (enters ? 1.0 / ior : double(ior));
        if (sine > 0.9999) continue;
        ASSERT_TRUE(f.kinds & EveryKernel::NEXT_REFRACTION);
        ASSERT_NEAR(f.refraction.direction.x, sine, 2e-5);
        ASSERT_LT(f.refraction.direction.z, 0.0f);
        ASSERT_EQ(f.refraction.medium, enters ? 1u : 0u);
        ASSERT_LT(f.refraction.origin.z, 0.0f) << "starts on the far side";
        ASSERT_GT(f.reflection.origin.z, 0.0f) << "starts on the near side";
    }
}

TEST(Whitted, ThinSurfacesDoNotBend) {
    Bench bench;
    bench.material.transmission = 1.0f;
    const Path p = pathUnder(0.3f);
    const Followed f = follow(bench, flatSurface(1.0f), p);
    EXPECT_EQ(f.refraction.direction, p.direction);
    EXPECT_EQ(f.refraction.medium, 0u);
}

TEST(Whitted, AnIndexOfOneIsInvisibleUnderEveryAngle) {
    Bench bench;
    bench.material.transmission = 1.0f;
    bench.material.ior = 1.0f;
    bench.material.roughness = 0.0f;
    for (uint32_t flags : {0u, uint32_t(MATERIAL_VOLUME)}) {
        for (float cosine : {1.0f, 0.5f, 0.01f, 1e-4f, 0.0f}) {
            bench.material.flags = flags;
            const Path p = pathUnder(cosine);
            const Followed f = follow(bench, flatSurface(1.0f), p);
            ASSERT_EQ(f.kinds, uint32_t(EveryKernel::NEXT_REFRACTION)) << cosine;
            EXPECT_LT(glm::length(f.refraction.direction - p.direction), cosine > 0.005f ? 1e-4f : 0.02f) << cosine;
            EXPECT_NEAR(f.refraction.throughput.x, 1.0f, 1e-6f);
            EXPECT_EQ(f.ended, vec3(0.0f));
        }
    }
}

// Normals that a map or interpolation has tilted far: what is reflected still leaves the facet.
TEST(Whitted, BentNormalsReflectAboveTheSurface) {
    Bench bench;
    bench.material.metallic = 1.0f;
    bench.material.roughness = 0.0f;
    Random random(4);
    for (int i = 0; i < 100000; i++) {
        auto s = flatSurface(1.0f);
        const double tilt = random.number(0.0, 85.0 * EXACT_PI / 180.0), turn = random.number(0.0, 2.0 * EXACT_PI);
        s.normal = vec3(float(std::sin(tilt) * std::cos(turn)), float(std::sin(tilt) * std::sin(turn)), float(std::cos(tilt)));
        const Followed f = follow(bench, s, pathUnder(random.real(1e-4f, 1.0f)));
        ASSERT_TRUE(f.kinds & EveryKernel::NEXT_REFLECTION);
        ASSERT_GT(f.reflection.direction.z, 0.0f);
        ASSERT_NEAR(glm::length(dvec3(f.reflection.direction)), 1.0, 1e-5);
        ASSERT_LE(f.reflection.throughput.x, 1.0f);
    }
}

TEST(Whitted, MediumAbsorbsByItsThickness) {
    Bench bench;
    bench.material.transmission = 1.0f;
    bench.material.flags = MATERIAL_VOLUME;
    bench.material.absorption = vec4(0.1f, 1.0f, 30.0f, 0.0f);
    bench.connect();
    auto s = flatSurface(-1.0f);
    for (float distance : {0.0f, 0.01f, 1.0f, 2.5f}) {
        s.distance = distance;
        const vec3 t = bench.kernel.mediumTransmittance(1u, s);
        EXPECT_NEAR(t.x, std::exp(-0.1 * distance), 1e-6);
        EXPECT_NEAR(t.y, std::exp(-1.0 * distance), 1e-6);
        EXPECT_NEAR(t.z, std::exp(-30.0 * distance), 1e-6);
        EXPECT_EQ(bench.kernel.mediumTransmittance(0u, s), t) << "a camera inside the body: its back says so";
    }
    s.side = 1.0f;
    EXPECT_EQ(bench.kernel.mediumTransmittance(0u, s), vec3(1.0f)) << "air";
    s.distance = 1e30f;
    EXPECT_TRUE(bench.kernel.isFinite3(bench.kernel.mediumTransmittance(1u, s)));
}

TEST(Whitted, ShadowRaysTakeTheColourOfWhatTheyPass) {
    Bench bench;
    bench.material.flags = MATERIAL_ALPHA_BLEND;
    bench.material.baseColor = vec4(0.2f, 0.4f, 0.6f, 0.25f);
    bench.connect();
    auto s = flatSurface(1.0f);
    EXPECT_NEAR(bench.kernel.surfaceTransmittance(s, vec3(0, 0, -1)).x, 0.75f, 1e-6f) << "a blended surface: 1 - alpha";
    bench.material = SceneBuilder::defaultMaterial();
    bench.material.transmission = 1.0f;
    bench.material.baseColor = vec4(0.2f, 0.4f, 0.6f, 1.0f);
    const vec3 pane = bench.kernel.surfaceTransmittance(s, vec3(0, 0, -1));
    EXPECT_NEAR(pane.x, 0.2f * 12.0f / 13.0f, 1e-5f) << "a thin pane has two interfaces";
    EXPECT_NEAR(pane.z, 0.6f * 12.0f / 13.0f, 1e-5f);
    bench.material.flags = MATERIAL_VOLUME;
    bench.material.absorption = vec4(0.5f, 0.5f, 0.5f, 0.0f);
    s.side = -1.0f;
    EXPECT_NEAR(bench.kernel.surfaceTransmittance(s, vec3(0, 0, 1)).x, 0.2f * 0.96f * std::exp(-1.0f), 1e-5f)
        << "leaving after 2 m";
}

TEST(Whitted, OcclusionIsTheVisibleShareToItsPower) {
    EveryKernel kernel = bareKernel();
    kernel.frame.aoSamples = 9;
    kernel.frame.aoPower = 1.0f;
    EXPECT_EQ(kernel.occlusionVisibility(0), 0.0f);
    EXPECT_EQ(kernel.occlusionVisibility(9), 1.0f);
    EXPECT_FLOAT_EQ(kernel.occlusionVisibility(3), 1.0f / 3.0f);
    kernel.frame.aoPower = 2.5f;
    EXPECT_NEAR(kernel.occlusionVisibility(3), std::pow(1.0 / 3.0, 2.5), 1e-6);
    EXPECT_EQ(kernel.occlusionVisibility(0), 0.0f);
    kernel.frame.aoPower = 0.0f;
    EXPECT_EQ(kernel.occlusionVisibility(0), 1.0f) << "power 0 is no darkening";
}

TEST(Whitted, CamerasConesVaryByHalfAMipLevel) {
    EveryKernel kernel = bareKernel();
    kernel.frame.effects = 0u;  // a pinhole at rest: no table of samples is needed
    kernel.frame.resolution = uvec2(64, 64);
    kernel.frame.camera.forward = vec3(0, 0, -1);
    kernel.frame.camera.right = vec3(0.1f, 0, 0);
    kernel.frame.camera.up = vec3(0, 0.1f, 0);
    kernel.frame.camera.pixelSpread = 0.01f;
    double low = 1e9, high = 0.0, levels = 0.0;
    const int count = 20000;
    for (int i = 0; i < count; i++) {
        const double spread = kernel.startSample(uvec2(i % 64, i / 64), 3u).coneSpread / 0.01;
        low = std::min(low, spread);
        high = std::max(high, spread);
        levels += std::log2(spread) / count;
    }
    EXPECT_GT(low, std::sqrt(0.5) * 0.9999);
    EXPECT_LT(high, std::sqrt(2.0) * 1.0001);
    EXPECT_LT(low, 0.72);
    EXPECT_GT(high, 1.4);
    EXPECT_NEAR(levels, 0.0, 0.02) << "on average the level that the pixel asks for";
}

TEST(Whitted, AnUnlitSurfaceShowsItsColourAndNothingElse) {
    Bench bench;
    bench.material.flags = MATERIAL_UNLIT;
    bench.material.baseColor = vec4(0.3f, 0.5f, 0.7f, 1.0f);
    bench.material.metallic = 0.0f;
    bench.material.transmission = 1.0f;
    bench.connect();
    const auto s = flatSurface(1.0f);
    const auto m = bench.kernel.shadingAt(s);
    EXPECT_EQ(bench.kernel.emittedRadiance(m, vec3(1.0f)), vec3(0.3f, 0.5f, 0.7f));
    const Followed f = follow(bench, s, pathUnder(0.5f));
    EXPECT_EQ(f.kinds, 0u);
    EXPECT_EQ(f.ended, vec3(0.0f));
    EXPECT_EQ(bench.kernel.ambientContribution(m, vec3(0, 0, 1), vec3(1.0f)), vec3(0.0f));
    EXPECT_EQ(bench.kernel.reflectedLight(m, vec3(0, 0, 1), vec3(0, 0, 1)), vec3(0.0f));
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "tests/image/picture.h"

#include "server/request/effect_rules.h"
#include "server/scene/generate/sky.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Light ball(vec3 position, float radius, float intensity) {
    Light light = pointLight(position, vec3(intensity));
    light.radius = radius;
    return light;
}

Settings rays(uint32_t samples) {
    Settings settings;
    settings.shadowSamples = samples;
    return settings;
}

/// A white floor of 20 m, and from x = 0 on to the left a roof at height 1, seen from under the edge, under `light`.
std::shared_ptr<const Scene> edgeUnder(const Light& light, bool roof = true) {
    SceneBuilder builder("edge");
    builder.setEnvironmentColor(vec3(0.0f));
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, ground(10.0f, white));
    if (roof) place(builder, panel(vec3(-10.0f, 1.0f, 10.0f), vec3(10, 0, 0), vec3(0, 0, -20), white));
    builder.addLight(light);
    return builder.finish();
}

/// Irradiance at (x, 0, z) on the floor from a ball above the edge of the roof, by midpoints over its cone.
double exactIrradiance(dvec3 at, dvec3 centre, double radius, double intensity) {
    const dvec3 to = centre - at;
    const double d2 = glm::dot(to, to), d = std::sqrt(d2), sin2 = radius * radius / d2, cosMax = std::sqrt(1.0 - sin2);
    const dvec3 axis = to / d, side = glm::normalize(glm::cross(axis, dvec3(0, 0, 1))), other = glm::cross(axis, side);
    const int n = 400;
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            const double c = 1.0 - (i + 0.5) / n * (1.0 - cosMax), s = std::sqrt(1.0 - c * c),
                         phi = 2 * EXACT_PI * (j + 0.5) / n;
            const dvec3 w = side * (s * std::cos(phi)) + other * (s * std::sin(phi)) + axis * c;
            if (at.x + w.x / w.y > 0.0) sum += w.y;  // passes height 1 beside the roof
        }
    const double radiance = intensity / (EXACT_PI * radius * radius);
    return radiance * 2 * EXACT_PI * (1.0 - cosMax) * sum / (n * n);
}

// The camera stands under the roof and looks at the floor beneath the edge; the ball is at height 3, the edge at 1: the half shadow
// of a ball of radius r reaches about r / 2 to both sides.
TEST(SoftShadows, ThePenumbraOfABallOverAnEdgeIsWhereGeometrySays) {
    const double radius = 0.4;
    const dvec3 centre(0.0, 3.0, 0.0);
    const auto scene = edgeUnder(ball(vec3(centre), float(radius), 30.0f));
    const Camera camera = lookAt(vec3(0.0f, 0.9f, 0.0f), vec3(0.0f, 0.0f, 0.0f), 5.7f);
    const Picture picture = render(scene, camera, rays(64), 16, uvec2(97, 9));
    int dark = 0, lit = 0, half = 0;
    for (uint32_t x = 0; x < picture.size.x; x++) {
        // The first sample's pixel centre stands for the pixel: the light changes little over its 10 mm.
        const dvec3 p = onPlane(camera, picture.size, x, 4, dvec3(0.0), dvec3(0, 1, 0));
        // Tangents from the floor point to the ball pass the edge at (0, 1): the distance of the centre from that line.
        const dvec2 to = glm::normalize(dvec2(-p.x, 1.0));
        const double off = (centre.x - p.x) * to.y - centre.y * to.x;  // > 0: the centre is on the open side
        const double expected = exactIrradiance(p, centre, radius, 30.0) / EXACT_PI;
        const double full = 30.0 / EXACT_PI * 3.0 / std::pow(9.0 + p.x * p.x, 1.5);
        if (off < -radius - 0.02) {
            ASSERT_EQ(picture.at(x, 4).x, 0.0f) << "umbra at " << p.x;
            dark++;
        } else if (off > radius + 0.02) {
            ASSERT_NEAR(picture.at(x, 4).x, full, 2e-3 * full) << "outside at " << p.x;
            lit++;
        } else {
            half++;
        }
        ASSERT_NEAR(picture.at(x, 4).x, expected, 0.012 * full) << "at " << p.x;
    }
    EXPECT_GT(dark, 10);
    EXPECT_GT(lit, 10);
    EXPECT_GT(half, 20);
}

// Seen from the floor a quad of half edges a and b at height h directly above: the integral of cos cos / d^2 over it.
TEST(SoftShadows, AQuadLightsTheFloorByItsArea) {
    const double a = 0.8, b = 0.5, h = 1.2, intensity = 5.0;
    Light quad = pointLight(vec3(0, float(h), 0), vec3(float(intensity)));
    quad.type = LIGHT_QUAD;
    quad.direction = vec3(0, -1, 0);
    quad.edge = vec3(float(a), 0, 0);
    quad.aspect = float(b / a);
    const auto scene = edgeUnder(quad, false);
    const Camera camera = lookAt(vec3(0.0f, 1.0f, 4.0f), vec3(0.0f), 50.0f);
    const Picture picture = render(scene, camera, rays(256));  // one sample, which goes through the pixels' centres
    for (uint32_t y = 60; y < picture.size.y; y += 6) {
        for (uint32_t x = 0; x < picture.size.x; x += 6) {
            const dvec3 p = onPlane(camera, picture.size, x, y, dvec3(0.0), dvec3(0, 1, 0));
            double sum = 0.0;
            const int n = 60;
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n; j++) {
                    const dvec3 q(a * (2 * (i + 0.5) / n - 1), h, b * (2 * (j + 0.5) / n - 1));
                    const double d2 = glm::dot(q - p, q - p);
                    sum += h * h / (d2 * d2);
                }
            const double expected = intensity * sum / (n * n) / EXACT_PI;
            ASSERT_NEAR(picture.at(x, y).x, expected, 0.01 * expected + 1e-4) << x << ' ' << y;
        }
    }
    const Picture above = render(scene, lookAt(vec3(0, 5, 0), vec3(0.0f), 1.0f), rays(16));
    EXPECT_GT(above.centre().x, 0.0f);
}

TEST(SoftShadows, ASunWithAnAngleSoftensByTheDistanceOfTheEdge) {
    Light light = sun(vec3(0, -1, 0), vec3(2.0f));
    light.radius = 0.1f;
    const auto scene = edgeUnder(light);
    const Camera camera = lookAt(vec3(0.0f, 0.9f, 0.0f), vec3(0.0f), 3.0f);
    const Picture picture = render(scene, camera, rays(64), 16, uvec2(97, 9));
    for (uint32_t x = 0; x < picture.size.x; x++) {
        const double at = onPlane(camera, picture.size, x, 4, dvec3(0.0), dvec3(0, 1, 0)).x;
        // A disc of radius 0.1 (all but a percent flat) cut at -at: the share of its area on the open side.
        const double t = std::clamp(at / 0.1, -1.0, 1.0);
        const double share = 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / EXACT_PI;
        ASSERT_NEAR(picture.at(x, 4).x, 2.0 / EXACT_PI * share, 0.015) << at;
    }
}

TEST(SoftShadows, AnUnhiddenBallLightsWhatFacesItAsAPointDoes) {
    for (float radius : {0.0f, 0.01f, 0.5f, 1.9f}) {
        const auto scene = edgeUnder(ball(vec3(0, 2, 0), radius, 10.0f), false);
        const Picture picture = render(scene, lookAt(vec3(0, 1, 0), vec3(0.0f), 1.0f), rays(256), 1, uvec2(3, 3));
        EXPECT_NEAR(picture.centre().x, 10.0 / 4.0 / EXACT_PI, 2e-3) << radius;
    }
}

TEST(SoftShadows, RaysAreCountedPerLightWithAnExtent) {
    SceneBuilder builder = darkness();
    place(builder, ground(100.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    builder.addLight(ball(vec3(0, 3, 0), 0.2f, 5.0f));
    builder.addLight(pointLight(vec3(1, 3, 0), vec3(5.0f)));
    builder.addLight(ball(vec3(0, -3, 0), 0.2f, 5.0f));  // behind the floor: no ray
    Light far = ball(vec3(0, 900, 0), 0.2f, 5.0f);
    far.range = 10.0f;  // out of range: no ray
    builder.addLight(far);
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 3, 0), vec3(0.0f), 20.0f);
    EXPECT_EQ(render(scene, camera, rays(7)).stats.rays[RayKind::shadow], (7u + 1u) * 97u * 97u);
    Settings off = rays(7);
    off.softShadows = false;
    EXPECT_EQ(render(scene, camera, off).stats.rays[RayKind::shadow], 2u * 97u * 97u) << "as points";
    off.softShadows = true;
    off.shadows = false;
    EXPECT_EQ(render(scene, camera, off).stats.rays[RayKind::shadow], 0u);
}

TEST(SoftShadows, OnlyLightsWithAnExtentCallForThem) {
    EXPECT_FALSE(effectsOf(*edgeUnder(ball(vec3(0, 2, 0), 0.0f, 1.0f))).has(EFFECT_SOFT_SHADOWS));
    EXPECT_TRUE(effectsOf(*edgeUnder(ball(vec3(0, 2, 0), 0.1f, 1.0f))).has(EFFECT_SOFT_SHADOWS));
    EXPECT_TRUE(effectsOf(*edgeUnder(generate::quadLight(vec3(0, 2, 0), vec3(1, 0, 0), vec2(1.0f), vec3(1.0f))))
                    .has(EFFECT_SOFT_SHADOWS));
    for (const EffectReason& reason : explainEffects(*edgeUnder(ball(vec3(0, 2, 0), 0.1f, 1.0f)))) {
        if (reason.bit == EFFECT_SOFT_SHADOWS) {
            EXPECT_EQ(reason.because, "1 light with an extent");
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <functional>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings glossySettings(bool on = true) {
    Settings settings;
    settings.glossyReflections = on;
    settings.contributionThreshold = 0.0f;
    settings.surfaceLights = false;  // its own rays alone
    return settings;
}

Material metal(float roughness) {
    Material m = SceneBuilder::defaultMaterial();
    m.metallic = 1.0f;
    m.roughness = roughness;
    return m;
}

/// Light that white GGX metal that reflects once about +y, of width a = roughness squared, reflects towards wo when `radiance(wi)` comes in. Midpoints
/// over half vectors, spread as the distribution has them; height-correlated shadowing (Heitz 2014).
double reflected(dvec3 wo, double a, const std::function<double(dvec3)>& radiance) {
    const int side = 600;
    double sum = 0.0;
    const auto lambda = [a](double c) { return 0.5 * (std::sqrt(1.0 + a * a * (1.0 - c * c) / (c * c)) - 1.0); };
    for (int i = 0; i < side; i++)
        for (int j = 0; j < side; j++) {
            const double u = (i + 0.5) / side, turn = 2.0 * EXACT_PI * (j + 0.5) / side;
            const double c = std::sqrt((1.0 - u) / (1.0 + (a * a - 1.0) * u)), s = std::sqrt(1.0 - c * c);
            const dvec3 h(s * std::cos(turn), c, s * std::sin(turn));
            const double woh = glm::dot(wo, h);
            const dvec3 wi = 2.0 * woh * h - wo;
            if (woh <= 0.0 || wi.y <= 0.0) continue;
            // D G2 / (4 cos cos) * cos(wi) over the density D c / (4 woh)
            sum += radiance(wi) / (1.0 + lambda(wo.y) + lambda(wi.y)) * woh / (wo.y * c);
        }
    return sum / (side * side);
}

// What bounces between facets is given back: white metal loses nothing of an even sky.
TEST(Glossy, ReflectsAllOfAnEvenSky) {
    for (float roughness : {0.1f, 0.2f, 0.5f, 1.0f}) {
        SceneBuilder builder = darkness(vec3(1.0f));
        place(builder, ground(100.0f, builder.addMaterial(metal(roughness), "metal")));
        const auto scene = builder.finish();
        for (float degrees : {20.0f, 60.0f, 80.0f}) {
            const float angle = glm::radians(degrees);
            const Camera camera = lookAt(5.0f * vec3(0.0f, std::cos(angle), std::sin(angle)), vec3(0.0f), 0.1f);
            double mean = 0.0;
            for (const vec4& p : render(scene, camera, glossySettings(), 512, uvec2(5, 5)).pixels) mean += p.x / 25.0;
            EXPECT_NEAR(mean, 1.0, 4e-3) << roughness << ' ' << degrees;
        }
    }
}

// The sky glows below 40 degrees of elevation only where a wall stands; the plate shows its upper edge blurred by the lobe.
TEST(Glossy, BlursAnEdgeByTheLobe) {
    for (float roughness : {0.1f, 0.2f, 0.3f, 0.5f}) {
        SceneBuilder builder = darkness();
        place(builder, ground(1.0f, builder.addMaterial(metal(roughness), "metal")));
        const uint32_t lamp = builder.addMaterial(glow(vec3(1.0f)), "lamp");
        place(builder, panel(vec3(-5000.0f, 0.5f, -1000.0f), vec3(10000, 0, 0), vec3(0, 1000, 0), lamp));
        const auto scene = builder.finish();
        for (float degrees : {35.0f, 45.0f, 55.0f}) {
            const float angle = glm::radians(degrees);
            const dvec3 wo(0.0, std::sin(angle), std::cos(angle));
            const double a = roughness * roughness, whole = reflected(wo, a, [](dvec3) { return 1.0; });
            const double lit = reflected(wo, a, [](dvec3 wi) {
                const double t = wi.z < 0.0 ? -1000.0 / wi.z : 0.0;
                return wi.z < 0.0 && wi.y * t < 1000.5 && wi.y * t > 0.5 && std::abs(wi.x * t) < 5000.0 ? 1.0 : 0.0;
            });
            const double expected = lit / whole;  // with what bounces between facets
            const Picture picture =
                render(scene, lookAt(vec3(5.0 * wo), vec3(0.0f), 0.1f), glossySettings(), 1024, uvec2(3, 3));
            EXPECT_NEAR(picture.centre().x, expected, 0.012) << roughness << ' ' << degrees;
        }
    }
}

TEST(Glossy, LeavesAMirrorAMirror) {
    SceneBuilder builder = darkness();
    place(builder, ground(1.0f, builder.addMaterial(metal(0.0f), "mirror")));
    Material enamel = SceneBuilder::defaultMaterial();
    enamel.roughness = 0.15f;
    place(builder, panel(vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 2, 0), builder.addMaterial(enamel, "enamel")));
    builder.addLight(pointLight(vec3(1, 3, 2), vec3(20.0f)));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 1.5f, 3), vec3(0, 0.2f, 0), 40.0f);
    const Picture with = render(scene, camera, glossySettings()), without = render(scene, camera, glossySettings(false));
    // The floor shows the enamel, whose own reflections are estimated there: bit for bit the same.
    int floor = 0;
    for (uint32_t y = 60; y < 97; y++) {
        for (uint32_t x = 30; x < 67; x++) {
            const dvec3 p = onPlane(camera, with.size, x, y, dvec3(0.0), dvec3(0, 1, 0));
            if (p.z < 0.05 || p.z > 0.95 || std::abs(p.x) > 0.95) continue;
            ASSERT_NEAR(with.at(x, y).x, without.at(x, y).x, 1e-5) << x << ' ' << y;
            floor++;
        }
    }
    EXPECT_GT(floor, 100);
    EXPECT_LE(with.stats.rays[RayKind::reflection], without.stats.rays[RayKind::reflection]);
    EXPECT_GT(with.stats.rays[RayKind::reflection], 0u);
}

TEST(Glossy, SurfacesOfEveryRoughnessGetAReflectionRay) {
    SceneBuilder builder = darkness(vec3(0.5f));
    place(builder, ground(10.0f, builder.addMaterial(metal(0.8f), "rough")));
    const auto scene = builder.finish();
    const Camera camera = lookAt(vec3(0, 2, 0), vec3(0.0f), 20.0f);
    ASSERT_TRUE(frameRequest(*scene, camera, glossySettings(), uvec2(8, 8), 1).effects.has(EFFECT_GLOSSY_REFLECTIONS));
    EXPECT_GT(render(scene, camera, glossySettings()).stats.rays[RayKind::reflection], 97u * 97u / 2u)
        << "all but those that would go below the surface";
    EXPECT_EQ(render(scene, camera, glossySettings(false)).stats.rays[RayKind::reflection], 0u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

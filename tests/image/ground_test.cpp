// Ground that is not seen but for the shadows on it.

#include "server/request/surroundings.h"
#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace heliograph::TEST_FILE {
using test::dvec2;
using test::dvec3;

namespace {

constexpr float HEIGHT = 2.0f;
constexpr uvec2 SIZE{101, 101};

/// A square of 2 m, level, two metres over the ground, under even light; a crumb far off says where the ground lies.
std::shared_ptr<const Scene> squareOver(float light, bool clear = false) {
    SceneBuilder builder("square");
    const auto add = [&](std::vector<vec3> corners, const Material& material) {
        MeshData mesh;
        mesh.positions = std::move(corners);
        mesh.indices = {{0, 1, 2}};
        if (mesh.positions.size() == 4) mesh.indices.push_back({0, 2, 3});
        mesh.materials.assign(mesh.indices.size(), builder.addMaterial(material, "matte"));
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    };
    Material pane = test::paint(vec3(0.25f));
    if (clear) {
        pane.flags |= MATERIAL_ALPHA_BLEND;
        pane.baseColor.w = 0.25f;
    }
    add({{-1, HEIGHT, 1}, {1, HEIGHT, 1}, {1, HEIGHT, -1}, {-1, HEIGHT, -1}}, pane);
    add({{-9, 0, -9}, {-9, 0, -9.01f}, {-9.01f, 0, -9}}, test::paint(vec3(0.25f)));
    Light sun{};
    sun.type = LIGHT_DIRECTIONAL;
    sun.direction = vec3(0, -1, 0);
    sun.intensity = vec3(light);
    builder.addLight(sun);
    builder.setEnvironmentColor(vec3(0.5f));
    return builder.finish();
}

Settings onGround(const char* more = "ground=on") {
    Settings settings;
    settings.setFromText("ground=on");
    settings.setFromText(more);
    settings.aoRadius = 0.0f;
    return settings;
}

/// Under the square, from beside.
const Camera BESIDE = test::lookAt(vec3(6, 1.5f, 0), vec3(0));

dvec2 placeOf(uint32_t x, uint32_t y) {
    const dvec3 d = test::rayThrough(BESIDE, SIZE, x, y);
    if (d.y >= 0.0) return {1e9, 1e9};
    const dvec3 p = dvec3(BESIDE.position) - d * (1.5 / d.y);
    return {p.x, p.z};
}

/// Calls `check(x, y, under)` for the pixels that see ground clearly under the square or clearly beside; returns how many are under.
template <typename Check>
uint32_t overGround(const Check& check) {
    uint32_t under = 0;
    for (uint32_t y = 0; y < SIZE.y; y++)
        for (uint32_t x = 0; x < SIZE.x; x++) {
            const dvec2 at = placeOf(x, y);
            const double edge = std::max(std::abs(at.x), std::abs(at.y));
            if (edge > 5.0 || std::abs(edge - 1.0) < 0.1) continue;
            under += edge < 1.0;
            check(x, y, edge < 1.0);
        }
    return under;
}

}  // namespace

// The sun brings pi / pi of 1.5: a third of the light is left in its shadow, and nothing changes beside it.
TEST(Ground, LosesTheLightThatIsKeptFromIt) {
    const auto scene = squareOver(std::numbers::pi_v<float>);
    const test::Picture plain = test::render(scene, BESIDE, {}, 4, SIZE);
    const test::Picture caught = test::render(scene, BESIDE, onGround(), 4, SIZE);
    const uint32_t under = overGround([&](uint32_t x, uint32_t y, bool shadow) {
        if (shadow) EXPECT_NEAR(caught.at(x, y).x, 0.5f / 3.0f, 1e-5f) << x << " " << y;
        else EXPECT_EQ(caught.at(x, y), plain.at(x, y)) << x << " " << y;
    });
    EXPECT_GT(under, 100u);
    EXPECT_EQ(caught.at(50, 2), plain.at(50, 2));  // the sky
    EXPECT_GT(caught.stats.rays[RayKind::shadow], plain.stats.rays[RayKind::shadow]);
}

// A pane that lets three quarters through takes a quarter of the sun's two thirds.
TEST(Ground, LosesWhatPanesTake) {
    const auto scene = squareOver(std::numbers::pi_v<float>, true);
    const test::Picture caught = test::render(scene, BESIDE, onGround(), 1, SIZE);
    const uint32_t under = overGround([&](uint32_t x, uint32_t y, bool shadow) {
        EXPECT_NEAR(caught.at(x, y).x, shadow ? 0.5f * (1.0f - 0.25f * 2.0f / 3.0f) : 0.5f, 1e-5f) << x << " " << y;
    });
    EXPECT_GT(under, 100u);
}

// Even light without a lamp: under the middle of the square the share of the sky that it covers is the form factor of a
// parallel square (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3, four times).
TEST(Ground, LosesEvenLightUnderneath) {
    const auto scene = squareOver(0.0f);
    Settings settings = onGround();
    settings.aoRadius = 1000.0f;
    settings.aoSamples = 64;
    const Camera camera = test::lookAt(vec3(6, 1.5f, 0), vec3(0), 0.02f);
    const test::Picture caught = test::render(scene, camera, settings, 64, uvec2(3, 3));
    const double a = 1.0 / HEIGHT, root = std::sqrt(1.0 + a * a);
    const double covered = 4.0 * 2.0 * (a / root * std::atan(a / root)) / (2.0 * std::numbers::pi);
    EXPECT_NEAR(caught.centre().x, 0.5 * (1.0 - covered), 0.002);
    settings.aoRadius = 0.0f;
    EXPECT_EQ(test::render(scene, camera, settings, 4, uvec2(3, 3)).centre(), vec3(0.5f));
}

// A camera under the ground looks through it.
TEST(Ground, IsSeenFromAboveAlone) {
    const auto scene = squareOver(std::numbers::pi_v<float>);
    const Camera below = test::lookAt(vec3(6, -1.5f, 0), vec3(0));
    const test::Picture plain = test::render(scene, below, {}, 1, SIZE);
    EXPECT_EQ(test::render(scene, below, onGround(), 1, SIZE).pixels, plain.pixels);
}

// With fog nobody knows what the air brings there: the ground is left out.
TEST(Ground, IsLeftOutInFog) {
    const auto scene = squareOver(1.0f);
    EXPECT_TRUE(frameRequest(*scene, BESIDE, onGround(), SIZE, 1).effects.has(EFFECT_GROUND));
    EXPECT_FALSE(frameRequest(*scene, BESIDE, onGround("fog=on"), SIZE, 1).effects.has(EFFECT_GROUND));
    EXPECT_FALSE(frameRequest(*scene, BESIDE, {}, SIZE, 1).effects.has(EFFECT_GROUND));
}

}  // namespace heliograph::TEST_FILE

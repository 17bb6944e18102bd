// The studio: what a file without any light is seen in.

#include "server/encode/tone_map.h"
#include "server/request/effect_rules.h"
#include "server/request/surroundings.h"
#include "server/scene/build/default_camera.h"
#include "server/scene/framing.h"
#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace heliograph::TEST_FILE {
namespace {

Material card(vec3 color) {
    Material material = SceneBuilder::defaultMaterial();
    material.baseColor = vec4(color, 1.0f);
    material.roughness = 0.5f;
    return material;
}

/// Squares in a row that face the default camera, as a file without any light would bring them.
std::shared_ptr<const Scene> cards(const std::vector<vec3>& colours) {
    SceneBuilder builder("cards");
    builder.setFromFile();
    builder.offerSurroundings(true);
    const vec3 forward = -vec3(DEFAULT_VIEW), right = glm::normalize(glm::cross(forward, vec3(0, 1, 0)));
    const vec3 up = glm::cross(right, forward);
    for (size_t i = 0; i < colours.size(); i++) {
        const vec3 left = right * (1.1f * static_cast<float>(i));
        MeshData mesh;
        mesh.positions = {left, left + right, left + right + up, left + up};
        mesh.indices = {{0, 1, 2}, {0, 2, 3}};
        mesh.materials.assign(2, builder.addMaterial(card(colours[i]), "card"));
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    }
    return builder.finish();
}

/// Codes of the picture's pixels as a viewer sees them.
std::vector<uint8_t> codes(const Scene& scene, const test::Picture& picture) {
    DisplayImage image;
    ToneMap(scene.exposure, shownCurve(ToneCurve::automatic, scene.fromFile)).apply(picture.pixels, picture.size, image);
    return image.rgba;
}

/// Base colours that come back, at the settings that a viewer starts with.
void expectComeBack(const std::vector<vec3>& colours) {
    const auto scene = cards(colours);
    ASSERT_TRUE(scene->inStudio);
    const auto width = static_cast<uint32_t>(colours.size()) * 16;
    NamedCamera afar = scene->cameras.front();  // so that all of them are seen along the same direction
    afar.fieldOfView = 2.0f;
    const Camera camera = checkedCamera(cameraFrom(framed(*scene->framing, afar, width / 32.0)));
    const test::Picture picture = test::render(scene, camera, {}, 4, uvec2(width, 32));
    const std::vector<uint8_t> shown = codes(*scene, picture);
    for (size_t i = 0; i < colours.size(); i++) {
        // Where the middle of the card is seen.
        const float middle = 1.1f * static_cast<float>(i) + 0.5f, all = 1.1f * static_cast<float>(colours.size()) - 0.1f;
        const auto x = static_cast<uint32_t>(width * (0.05f + 0.9f * middle / all));
        const uint8_t* rgb = &shown[(16 * size_t(width) + x) * 4];
        for (int c = 0; c < 3; c++) {
            const double wanted = 255.0 * srgbCode(colours[i][c]);
            EXPECT_NEAR(rgb[c], wanted, 4.0) << "card " << i << " channel " << c;
        }
        testing::Test::RecordProperty("card" + std::to_string(i),
                                      std::to_string(rgb[0]) + " " + std::to_string(rgb[1]) + " " + std::to_string(rgb[2]));
    }
}

TEST(Studio, GreysComeBack) {
    expectComeBack({vec3(0.02f), vec3(0.05f), vec3(0.1f), vec3(0.18f), vec3(0.35f), vec3(0.55f), vec3(0.75f)});
}

TEST(Studio, ColoursComeBack) {
    expectComeBack({vec3(0.6f, 0.05f, 0.04f), vec3(0.05f, 0.45f, 0.08f), vec3(0.05f, 0.2f, 0.7f), vec3(0.7f, 0.55f, 0.05f),
                    vec3(0.5f, 0.1f, 0.4f), vec3(0.08f, 0.4f, 0.45f), vec3(0.55f, 0.3f, 0.2f), vec3(0.2f, 0.12f, 0.08f)});
}

TEST(Studio, IsBehindNothing) {
    const auto scene = cards({vec3(0.5f)});
    const Camera camera = checkedCamera(cameraFrom(startCamera(*scene, 1.0)));
    const auto corner = [&](const char* background) {
        Settings settings;
        settings.set("background", background);
        return test::render(scene, camera, settings, 1, uvec2(32, 32)).at(0, 0);
    };
    EXPECT_EQ(corner("automatic"), corner("plain"));
    EXPECT_EQ(corner("plain").x, corner("plain").y);
    EXPECT_NE(corner("image"), corner("plain"));
    EXPECT_NE(corner("blurred"), corner("image"));
    EXPECT_EQ(*plainBackdrop(*scene, {}, effectsUnder(*scene, effectsOf(*scene), {})), corner("plain"));
}

// Where a scene is surrounded by another than its own, light, tables and effects are all the other's.
TEST(Studio, SurroundingsCanBeChosen) {
    const auto scene = cards({vec3(0.5f)});
    const Camera camera = checkedCamera(cameraFrom(startCamera(*scene, 1.0)));
    const auto middle = [&](const std::string& surroundings, float strength) {
        Settings settings;
        settings.set("surroundings", surroundings);
        settings.environmentStrength = strength;
        return test::render(scene, camera, settings, 16, uvec2(33, 33)).centre();
    };
    EXPECT_EQ(middle("none", 1.0f), vec3(0.0f));
    EXPECT_NEAR(middle("grey", 1.0f).x, 0.8f * (0.5f * 0.963f + 0.037f), 0.004f);
    EXPECT_NEAR(middle("grey", 3.0f).x, 3.0f * middle("grey", 1.0f).x, 1e-4f);
    EXPECT_EQ(middle("studio", 1.0f), middle("automatic", 1.0f));
    EXPECT_NEAR(middle("studio", 0.5f).x, 0.5f * middle("studio", 1.0f).x, 1e-4f);
    EXPECT_GT(middle("sky", 1.0f).z, 0.1f);
}

/// A floor of 20 m with a wall of 4 m along x = 0, seen straight from above.
std::shared_ptr<const Scene> wallOnFloor() {
    SceneBuilder builder("wall");
    const auto quad = [&](vec3 a, vec3 b, vec3 c, vec3 d) {
        MeshData mesh;
        mesh.positions = {a, b, c, d};
        mesh.indices = {{0, 1, 2}, {0, 2, 3}};
        mesh.materials.assign(2, builder.addMaterial(test::paint(vec3(0.5f)), "matte"));
        builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
    };
    quad(vec3(-10, 0, 10), vec3(10, 0, 10), vec3(10, 0, -10), vec3(-10, 0, -10));
    quad(vec3(0, 0, 10), vec3(0, 4, 10), vec3(0, 4, -10), vec3(0, 0, -10));
    Light unlit{};  // takes the headlight's place
    unlit.type = LIGHT_DIRECTIONAL;
    unlit.direction = vec3(0, -1, 0);
    builder.addLight(unlit);
    builder.setEnvironmentColor(vec3(0.0f));
    return builder.finish();
}

// The sun's light on a floor, and the half shadow of a wall's edge: as much of the disc as stands over it.
TEST(Sun, LightsTheFloorAndThrowsItsHalfShadow) {
    const auto scene = wallOnFloor();
    Settings settings;
    settings.setFromText("sun=on");
    settings.sunAzimuth = -90.0f;  // from -x: the shadow falls to +x
    settings.sunElevation = 45.0f;
    settings.sunSize = 8.0f;
    settings.sunStrength = 2.0f;
    settings.shadowSamples = 64;
    const Camera camera = test::lookAt(vec3(0, 30, 0), vec3(0.0f), 2.0f * glm::degrees(std::atan(10.0f / 30.0f)));
    const uint32_t size = 101;
    const test::Picture picture = test::render(scene, camera, settings, 16, uvec2(size, size));
    const double full = 0.5 / std::numbers::pi * 2.0 * std::sqrt(0.5), radius = 4.0;  // degrees
    for (uint32_t x = 0; x < size; x++) {
        const double place = 10.0 * (2.0 * (x + 0.5) / size - 1.0);
        if (std::abs(place) < 0.5) continue;  // the wall is seen here
        double visible = 1.0;
        if (place > 0.0) {
            // The edge of the wall is seen under this angle; the disc's part above it.
            const double edge = glm::degrees(std::atan2(4.0, place));
            const double h = std::clamp((45.0 - edge) / radius, -1.0, 1.0);
            visible = 0.5 + (std::asin(h) + h * std::sqrt(1.0 - h * h)) / std::numbers::pi;
        }
        EXPECT_NEAR(picture.at(x, size / 2).x, full * visible, 0.02 * full) << "at " << place << " m";
    }
    EXPECT_EQ(test::render(scene, camera, {}, 1, uvec2(33, 33)).at(5, 16), vec3(0.0f));  // without it, night
}

TEST(Studio, TurningTheSurroundingsIsTurningTheImage) {
    // The same image, turned as it is built and by the setting; once smooth (nine coefficients), once with tables.
    for (const float sharp : {0.5f, 60.0f}) {
        const auto built = [&](float radians) {
            SceneBuilder builder("turned");
            ImageData image{.width = 64, .height = 32, .srgb = false, .rgba8 = {}, .rgb32f = {}, .name = "lobe"};
            for (uint32_t y = 0; y < 32; y++)
                for (uint32_t x = 0; x < 64; x++) {
                    const float v = 1.0f + sharp * static_cast<float>(std::exp(-0.02 * (sharp > 1.0f ? 10 : 1) *
                                                                               (std::pow(x - 20.0, 2) + std::pow(y - 9.0, 2))));
                    image.rgb32f.insert(image.rgb32f.end(), {v, 0.5f * v, 0.25f});
                }
            builder.setEnvironmentImage(builder.addImage(image), 1.0f, radians);
            MeshData mesh = test::icosphere(4);
            builder.addInstance(builder.addMesh(mesh), mat4(1.0f));
            return builder.finish();
        };
        const Camera camera = test::lookAt(vec3(0, 1, 5), vec3(0.0f));
        Settings turned;
        turned.environmentRotation = 50.0f;
        const test::Picture byImage = test::render(built(glm::radians(50.0f)), camera, {}, 64, uvec2(33, 33));
        const test::Picture bySetting = test::render(built(0.0f), camera, turned, 64, uvec2(33, 33));
        for (size_t i = 0; i < byImage.pixels.size(); i++)
            for (int c = 0; c < 3; c++)
                ASSERT_NEAR(byImage.pixels[i][c], bySetting.pixels[i][c], 2e-3f * (1.0f + byImage.pixels[i][c]));
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

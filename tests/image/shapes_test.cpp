// Analytic shapes in pictures.

#include "tests/image/picture.h"

#include "server/request/effect_rules.h"
#include "server/request/picked.h"
#include "server/scene/shape.h"

#include <glm/gtc/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

void placeShape(SceneBuilder& builder, ShapeForm form, const Material& material, const mat4& toWorld) {
    builder.addInstance(builder.addShape(form, builder.addMaterial(material, "shape")), toWorld);
}
mat4 at(vec3 center, float size = 1.0f) { return glm::translate(mat4(1.0f), center) * glm::scale(mat4(1.0f), vec3(size)); }

double meanOf(const Picture& picture) {
    double sum = 0.0;
    for (const vec4& p : picture.pixels) sum += p.x + p.y + p.z;
    return sum / (3.0 * double(picture.pixels.size()));
}

/// Sum of differences over sum of values.
double differenceOf(const Picture& a, const Picture& b) {
    double off = 0.0, sum = 0.0;
    for (size_t i = 0; i < a.pixels.size(); i++)
        off += glm::length(vec3(a.pixels[i]) - vec3(b.pixels[i])), sum += glm::length(vec3(b.pixels[i]));
    return off / sum;
}

TEST(ShapePictures, ABallIsLitAsABallIs) {
    SceneBuilder builder = darkness();
    placeShape(builder, {SHAPE_SPHERE}, paint(vec3(0.5f)), mat4(1.0f));
    const vec3 toLight = glm::normalize(vec3(1, 2, 2));
    builder.addLight(sun(-toLight, vec3(3.0f)));
    const Camera camera = lookAt({0, 0, 4}, vec3(0));
    const Picture picture = render(builder.finish(), camera);
    double most = 0.0;
    uint32_t seen = 0;
    for (uint32_t y = 0; y < picture.size.y; y++)
        for (uint32_t x = 0; x < picture.size.x; x++) {
            const dvec3 d = rayThrough(camera, picture.size, x, y), o(camera.position);
            const double t = meetsUnitSphere(o, d);
            if (t < 0.0 && picture.at(x, y) == vec3(0.0f)) continue;
            const dvec3 p = o + d * t;
            const double cosine = glm::dot(p, dvec3(toLight)), rim = -glm::dot(p, d);
            if (t < 0.0 || rim < 0.02) continue;  // a pixel whose centre passes by the rim
            most = std::max(most, std::abs(picture.at(x, y).x - std::max(cosine, 0.0) * 3.0 * 0.5 / EXACT_PI));
            seen++;
        }
    EXPECT_GT(seen, 2000u);
    EXPECT_LT(most, 2e-4);
}

// What a hundred thousand triangles come near.
TEST(ShapePictures, ShapesLookLikeTheirTriangles) {
    const auto pictureOf = [](bool shapes) {
        SceneBuilder builder("test");
        const mat4 toWorld = glm::rotate(glm::translate(mat4(1.0f), vec3(0.2f, 1.0f, 0)), 0.6f, glm::normalize(vec3(1, 2, 0))) *
                             glm::scale(mat4(1.0f), vec3(1.0f, 0.6f, -1.4f));
        const uint32_t clay = builder.addMaterial(paint({0.6f, 0.3f, 0.2f}), "clay");
        if (shapes) builder.addInstance(builder.addShape({SHAPE_SPHERE}, clay), toWorld);
        else place(builder, icosphere(7, clay), toWorld);
        place(builder, ground(6.0f, builder.addMaterial(paint(vec3(0.7f)), "floor")));
        builder.addLight(sun(glm::normalize(vec3(-1, -2, -1)), vec3(2.0f)));
        builder.setEnvironmentColor(vec3(0.3f));
        Settings settings;
        settings.aoRadius = 0.5f;
        return render(builder.finish(), lookAt({1, 3, 6}, {0, 0.8f, 0}), settings, 4);
    };
    EXPECT_LT(differenceOf(pictureOf(true), pictureOf(false)), 2e-3);
}

// Under even light a body that takes nothing away cannot be seen.
TEST(ShapePictures, ClearBodiesVanishInEvenLight) {
    for (const ShapeForm form : {ShapeForm{SHAPE_SPHERE}, ShapeForm{SHAPE_CYLINDER, true}}) {
        SceneBuilder builder = darkness(vec3(1.0f));
        placeShape(builder, form, glass(1.5f), glm::rotate(mat4(1.0f), 0.9f, glm::normalize(vec3(1, 1, 2))));
        Settings settings;
        settings.maxRefractions = 16;
        settings.maxReflections = 16;
        const Picture picture = render(builder.finish(), lookAt({0, 0, 5}, vec3(0)), settings, 4);
        for (const vec4& p : picture.pixels) ASSERT_NEAR(p.x, 1.0f, 5e-3f) << shapeName(form.kind);
    }
}

TEST(ShapePictures, OneThatGlowsLightsOthersByChance) {
    const auto pictureOf = [](bool shape) {
        SceneBuilder builder = darkness();
        const uint32_t lamp = builder.addMaterial(glow(vec3(4.0f)), "lamp");
        if (shape) builder.addInstance(builder.addShape({SHAPE_SPHERE}, lamp), at({0, 2, 0}));
        else place(builder, icosphere(5, lamp), at({0, 2, 0}));
        place(builder, ground(4.0f, builder.addMaterial(paint(vec3(0.8f)), "floor")));
        Settings settings;
        settings.setFromText("integrator=path");
        return meanOf(render(builder.finish(), lookAt({0, 3, 7}, {0, 0.5f, 0}), settings, 256, uvec2(49, 49)));
    };
    EXPECT_NEAR(pictureOf(true) / pictureOf(false), 1.0, 0.02);
}

TEST(ShapePictures, HolesOfACutOutShowItsOtherSide) {
    SceneBuilder builder = darkness(vec3(0.0f));
    ImageData stripes;
    stripes.width = 2, stripes.height = 1;
    stripes.rgba8 = {255, 255, 255, 0, 255, 255, 255, 255};
    TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(stripes));
    slot.nearest = 1;
    Material cut = glow(vec3(1.0f));
    cut.flags |= MATERIAL_ALPHA_MASK;
    cut.baseTexture = builder.addTexture(slot);
    placeShape(builder, {SHAPE_SPHERE}, cut, mat4(1.0f));
    // u < 1/2 is a hole: the half of x < 0. From there the inside of the other half is seen, from +x its outside.
    const auto scene = builder.finish();
    for (float side : {-1.0f, 1.0f}) {
        const Picture picture = render(scene, lookAt({side * 5.0f, 0, 0.001f}, vec3(0)));
        EXPECT_EQ(picture.centre(), vec3(1.0f)) << side;
        const DepthAnswer answer = cpu().depthAlong({dvec3(side * 5.0, 0.0, 0.1), dvec3(-side, 0, 0)});
        ASSERT_TRUE(answer.depth);
        EXPECT_NEAR(*answer.depth, 5.0 - side * std::sqrt(0.99), 1e-5) << side;
    }
}

TEST(ShapePictures, WhatIsPickedHasTheShapesNormalAndName) {
    SceneBuilder builder = darkness();
    builder.addInstance(builder.addShape({SHAPE_SPHERE}, builder.addMaterial(paint(vec3(1.0f)), "paint")), at({3, 0, 0}, 2.0f),
                        "moon");
    const auto scene = builder.finish();
    cpu().load(scene, {}, {});
    const ViewRay ray{dvec3(3.5, 1, 9), dvec3(0, 0, -1)};
    const DepthAnswer answer = cpu().depthAlong(ray);
    ASSERT_TRUE(answer.depth);
    const double height = std::sqrt(4.0 - 0.25 - 1.0);
    EXPECT_NEAR(*answer.depth, 9.0 - height, 1e-5);
    const Picked picked = pickedAt(*scene, ray, *answer.depth, answer.instance, answer.triangle);
    EXPECT_EQ(picked.object, "moon");
    EXPECT_EQ(picked.material, "paint");
    EXPECT_LT(glm::length(picked.normal - dvec3(0.25, 0.5, 0.5 * height)), 1e-5);
}

// A ball of 2^20 m as ground: no ring, band or spot of its own shadow in it.
TEST(ShapePictures, GroundOfAHugeBallIsEven) {
    SceneBuilder builder("test");
    placeShape(builder, {SHAPE_SPHERE}, paint(vec3(0.5f)), at({0, -0x1p20f, 0}, 0x1p20f));
    builder.addLight(sun(vec3(0, -1, 0), vec3(1.0f)));
    builder.setEnvironmentColor(vec3(0.5f));
    Settings settings;
    settings.aoRadius = 1e-6f;
    const Camera camera = lookAt({0, 2, 0}, {0, 1, 4}, 50.0f);
    const auto scene = builder.finish();
    const Picture picture = render(scene, camera, settings);
    const uvec2 size = picture.size;
    const float expected = 0.5f * (1.0f / float(EXACT_PI) + 0.5f);
    uint32_t ground = 0;
    for (uint32_t y = 0; y < size.y; y++)
        for (uint32_t x = 0; x < size.x; x++) {
            if (rayThrough(camera, size, x, y).y > -0.004) continue;  // the horizon is 0.002 below the level
            ASSERT_NEAR(picture.at(x, y).x, expected, 1e-4f) << x << " " << y;
            ground++;
        }
    EXPECT_GT(ground, 4000u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

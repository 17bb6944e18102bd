// Textures at a flat angle, and images of occlusion.

#include "tests/image/picture.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

ImageData chequer(uint32_t size) {
    ImageData image;
    image.width = image.height = size;
    image.srgb = false;
    for (uint32_t i = 0; i < size * size; i++) {
        const bool white = ((i % size * 8 / size) + (i / size * 8 / size)) % 2 != 0;
        image.rgba8.insert(image.rgba8.end(),
                           {uint8_t(white ? 255 : 0), uint8_t(white ? 255 : 0), uint8_t(white ? 255 : 0), 255});
    }
    return image;
}

/// A floor of fields of 0.25 m in white surroundings; `nearest`: its texels as they are.
std::shared_ptr<const Scene> chequeredFloor(bool nearest) {
    SceneBuilder builder = darkness(vec3(1.0f));
    Material m = paint(vec3(1.0f));
    TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(chequer(512)));
    slot.nearest = nearest ? 1 : 0;
    slot.transform = vec4(0.5f, 0.0f, 0.0f, 0.5f);
    m.baseTexture = builder.addTexture(slot);
    MeshData floor = ground(100.0f, builder.addMaterial(m, "floor"));
    floor.uv0.clear();
    for (vec3 p : floor.positions) floor.uv0.emplace_back(p.x, p.z);
    place(builder, floor);
    return builder.finish();
}

const uvec2 SIZE(320, 180);
const Camera LOW = lookAt(vec3(0.1f, 1.0f, 0.0f), vec3(0.7f, 0.4f, -6.0f), 40.0f);

/// Deviation from the mean in the rows where the floor is between two distances.
double contrast(const Picture& picture, double from, double to) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (uint32_t y = 0; y < SIZE.y; y++) {
        const dvec3 p = onPlane(LOW, SIZE, SIZE.x / 2, y, dvec3(0.0), dvec3(0, 1, 0));
        if (!(p.z < -from && p.z > -to)) continue;
        for (uint32_t x = 0; x < SIZE.x; x++) {
            const double value = picture.at(x, y).x;
            sum += value, squares += value * value, count += 1.0;
        }
    }
    return std::sqrt(squares / count - sum * sum / (count * count));
}

Picture ofFloor(const std::shared_ptr<const Scene>& scene, bool anisotropic, uint32_t samples) {
    Settings settings;
    if (anisotropic) settings.textureFilter = Settings::choice("textureFilter", "anisotropic");
    return render(scene, LOW, settings, samples, SIZE);
}

// Of the contrast of texels taken one by one a thousand times a pixel, the long filter keeps 0.9 and more, in front and at middle
// distance; what the round one keeps there is why.
TEST(TextureFilter, AFlatFloorKeepsItsContrast) {
    const auto floor = chequeredFloor(false);
    const Picture exact = ofFloor(chequeredFloor(true), false, 1024);
    const Picture along = ofFloor(floor, true, 64), round = ofFloor(floor, false, 64);
    const double metres[][2] = {{2.0, 4.0}, {4.0, 8.0}, {8.0, 14.0}};
    for (const auto& [from, to] : metres) {
        const double whole = contrast(exact, from, to);
        std::printf("contrast %4.1f to %4.1f m: %.3f; of that anisotropic %.3f, trilinear %.3f\n", from, to, whole,
                    contrast(along, from, to) / whole, contrast(round, from, to) / whole);
        EXPECT_GE(contrast(along, from, to) / whole, 0.9) << from;
        EXPECT_LE(contrast(along, from, to) / whole, 1.02) << from;
        EXPECT_GT(contrast(along, from, to), contrast(round, from, to)) << from;
    }
}

// One sample is no more aliased than 64 are: what is finer than a pixel is averaged, not hit or missed.
TEST(TextureFilter, OneSampleIsFilteredToo) {
    const auto floor = chequeredFloor(false);
    const Picture one = ofFloor(floor, true, 1), many = ofFloor(floor, true, 64);
    EXPECT_NEAR(contrast(one, 8.0, 14.0) / contrast(many, 8.0, 14.0), 1.0, 0.25);
    EXPECT_LT(contrast(one, 30.0, 90.0), 0.1) << "far away it is grey";
}

// Without a texture the setting changes no bit.
TEST(TextureFilter, NothingChangesWhereThereIsNoTexture) {
    SceneBuilder builder = darkness(vec3(1.0f));
    place(builder, ground(10.0f, builder.addMaterial(paint(vec3(0.5f)), "floor")));
    const auto scene = builder.finish();
    const Picture a = ofFloor(scene, false, 1), b = ofFloor(scene, true, 1);
    for (size_t i = 0; i < a.pixels.size(); i++) ASSERT_EQ(a.pixels[i], b.pixels[i]);
}

// ---- images of occlusion ----

/// A floor in surroundings of 1, under a sun that gives it 2 more where `sunny`; its occlusion image is `code` of 255 all over.
std::shared_ptr<const Scene> hollowFloor(uint8_t code, float strength, bool sunny, bool image = true) {
    SceneBuilder builder = darkness(vec3(1.0f));
    Material m = paint(vec3(0.5f));
    ImageData hollow;
    hollow.width = hollow.height = 1;
    hollow.srgb = false;
    hollow.rgba8 = {code, 255, 255, 255};
    if (image) m.occlusionTexture = builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(hollow)));
    m.occlusionStrength = strength;
    place(builder, ground(50.0f, builder.addMaterial(m, "floor")));
    if (sunny) builder.addLight(sun(vec3(0, -1, 0), vec3(float(2.0 * EXACT_PI))));
    return builder.finish();
}

double floorSeen(const std::shared_ptr<const Scene>& scene, const Settings& settings, uint32_t samples = 1) {
    return render(scene, lookAt(vec3(0, 2, 0), vec3(0.0f), 20.0f), settings, samples, uvec2(5, 5)).centre().x;
}

// 0.5 (1 + s (o - 1)) of the surroundings, and all of the sun's 0.5 x 2.
TEST(OcclusionTextures, ScaleTheAmbientLightAndNothingElse) {
    for (float strength : {0.25f, 1.0f}) {
        const double left = 1.0 + strength * (51.0 / 255.0 - 1.0);
        EXPECT_NEAR(floorSeen(hollowFloor(51, strength, false), {}), 0.5 * left, 1e-5) << strength;
        EXPECT_NEAR(floorSeen(hollowFloor(51, strength, true), {}), 0.5 * left + 1.0, 1e-5) << strength;
    }
    Settings off;
    off.occlusionTextures = false;
    EXPECT_EQ(floorSeen(hollowFloor(51, 1.0f, true), off), floorSeen(hollowFloor(51, 1.0f, true, false), {}));
}

// Where rays find out what hides the surroundings, an image of it would count it twice.
TEST(OcclusionTextures, AreLeftOutWhereOcclusionIsTraced) {
    Settings traced, path;
    traced.ambientOcclusion = true;
    path.integrator = Settings::choice("integrator", "path");
    for (const Settings& settings : {traced, path})
        EXPECT_EQ(floorSeen(hollowFloor(51, 1.0f, true), settings, 16),
                  floorSeen(hollowFloor(51, 1.0f, true, false), settings, 16));
}

// Indirect rays bring the diffuse light themselves; the image counts where they end.
TEST(OcclusionTextures, CountWhereIndirectLightEnds) {
    Settings settings;
    settings.indirectLight = true;
    settings.contributionThreshold = 0.0f;
    EXPECT_NEAR(floorSeen(hollowFloor(51, 1.0f, false), settings, 16), 0.5, 1e-5) << "an open floor sees all of the sky";
}

}  // namespace
}  // namespace heliograph::TEST_FILE

// What a surface looks like: emission, colours, textures, tilted normals.

#include "tests/image/picture.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

ImageData imageOf(uint32_t width, uint32_t height, bool srgb, const std::vector<uint32_t>& words) {
    ImageData image;
    image.width = width;
    image.height = height;
    image.srgb = srgb;
    for (uint32_t word : words)
        for (int c = 0; c < 4; c++) image.rgba8.push_back(static_cast<uint8_t>(word >> (8 * c)));
    return image;
}

double decodeSrgb(double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); }

/// The square z = 0 from (-1, -1) to (1, 1), u to the right, v downwards (top row of an image on top).
MeshData poster(uint32_t material) {
    MeshData mesh = panel(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0), material);
    for (vec2& uv : mesh.uv0) uv.y = 1.0f - uv.y;
    return mesh;
}

const Camera FRONT = lookAt(vec3(0, 0, 4), vec3(0.0f), 30.0f);

TEST(Look, EmissionShowsAsItIs) {
    SceneBuilder builder = darkness();
    place(builder, poster(builder.addMaterial(glow(vec3(0.5f, 2.0f, 17.0f)), "lamp")));
    EXPECT_EQ(render(builder.finish(), FRONT).centre(), vec3(0.5f, 2.0f, 17.0f));
}

TEST(Look, UnlitIsItsColourExactly) {
    SceneBuilder builder = darkness(vec3(3.0f));
    Material m = SceneBuilder::defaultMaterial();
    m.flags = MATERIAL_UNLIT;
    m.roughness = 0.0f;
    m.baseColor = vec4(0.25f, 0.5f, 0.75f, 1.0f);
    place(builder, icosphere(3, builder.addMaterial(m, "unlit")));
    builder.addLight(pointLight(vec3(0, 1, 3), vec3(100.0f)));
    Settings settings;
    settings.ambientOcclusion = true;
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)), settings);
    for (vec4 p : picture.pixels) {
        ASSERT_TRUE(vec3(p) == vec3(3.0f) || vec3(p) == vec3(0.25f, 0.5f, 0.75f)) << p.x << ' ' << p.y << ' ' << p.z;
    }
    EXPECT_EQ(picture.stats.rays[RayKind::shadow], 0u);
}

TEST(Look, VertexColoursAreInterpolatedAndMultiply) {
    SceneBuilder builder = darkness(vec3(1.0f));
    MeshData mesh = poster(builder.addMaterial(paint(vec3(0.5f, 1.0f, 1.0f)), "paint"));
    mesh.colors = {{0, 0, 1, 1}, {1, 0, 1, 1}, {1, 1, 1, 1}, {0, 1, 1, 1}};
    place(builder, mesh);
    const Picture picture = render(builder.finish(), FRONT);
    for (uint32_t y = 0; y < picture.size.y; y += 3) {
        for (uint32_t x = 0; x < picture.size.x; x += 3) {
            const dvec3 p = onPlane(FRONT, picture.size, x, y, dvec3(0.0), dvec3(0, 0, 1));
            if (std::max(std::abs(p.x), std::abs(p.y)) > 0.99) continue;
            ASSERT_NEAR(picture.at(x, y).x, 0.5 * (p.x + 1) / 2, 1e-5);
            ASSERT_NEAR(picture.at(x, y).y, (p.y + 1) / 2, 1e-5);
        }
    }
}

TEST(Look, TexturesShowTheTexelThatBelongsThere) {
    SceneBuilder builder = darkness(vec3(1.0f));
    std::vector<uint32_t> words;
    for (uint32_t i = 0; i < 16; i++) words.push_back(0xff000000u | (i * 16) | (255 - i * 16) << 8 | (i % 2 ? 200u << 16 : 0u));
    TextureSlot slot = SceneBuilder::defaultTexture(builder.addImage(imageOf(4, 4, true, words)));
    slot.nearest = 1;
    Material m = paint(vec3(1.0f));
    m.baseTexture = builder.addTexture(slot);
    place(builder, poster(builder.addMaterial(m, "poster")));
    const Picture picture = render(builder.finish(), FRONT);
    for (uint32_t y = 0; y < picture.size.y; y++) {
        for (uint32_t x = 0; x < picture.size.x; x++) {
            const dvec3 p = onPlane(FRONT, picture.size, x, y, dvec3(0.0), dvec3(0, 0, 1));
            const double u = (p.x + 1) * 2, v = (1 - p.y) * 2;
            if (u < 0.0 || u >= 4.0 || v < 0.0 || v >= 4.0) continue;
            if (std::abs(u - std::round(u)) < 1e-4 || std::abs(v - std::round(v)) < 1e-4) continue;
            const uint32_t word = words[int(v) * 4 + int(u)];
            for (int c = 0; c < 3; c++)
                ASSERT_NEAR(picture.at(x, y)[c], decodeSrgb((word >> (8 * c) & 255u) / 255.0), 1e-3) << x << ' ' << y;
        }
    }
}

// A fine chequer seen from far away is its mean in linear light, not a moire.
TEST(Look, FineTexturesAreFilteredToTheirMean) {
    SceneBuilder builder = darkness(vec3(1.0f));
    std::vector<uint32_t> words;
    for (uint32_t i = 0; i < 256 * 256; i++) words.push_back((i + i / 256) % 2 ? 0xffffffffu : 0xff000000u);
    Material m = paint(vec3(1.0f));
    m.baseTexture = builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(imageOf(256, 256, true, words))));
    place(builder, poster(builder.addMaterial(m, "chequer")));
    const Picture picture = render(builder.finish(), lookAt(vec3(0, 0, 14), vec3(0.0f), 4.0f), {}, 4, uvec2(33, 33));
    for (vec4 p : picture.pixels) ASSERT_NEAR(p.x, 0.5f, 0.06f);
}

// ---- tilted normals ----

/// Light that a poster with a normal image shows under a sun from `toSun`, as a share of what it would face.
double litShare(const ImageData& normals, bool bump, float scale, vec3 toSun, bool placed = false, bool mirrored = false) {
    SceneBuilder builder = darkness();
    Material m = paint(vec3(1.0f));
    m.normalTexture = builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(normals)));
    m.normalScale = scale;
    if (bump) m.flags |= MATERIAL_BUMP;
    const uint32_t mesh = builder.addMesh(poster(builder.addMaterial(m, "relief")));
    mat4 toWorld(1.0f);
    if (mirrored) toWorld[0].x = -1.0f;
    builder.addInstance(mesh, toWorld);
    if (placed) {
        toWorld[3] = vec4(100, 0, 0, 1);
        builder.addInstance(mesh, toWorld);
    }
    builder.addLight(sun(-toSun, vec3(float(EXACT_PI))));
    return render(builder.finish(), lookAt(vec3(0.1f, 0.1f, 4), vec3(0.1f, 0.1f, 0), 10.0f), {}, 1, uvec2(9, 9)).centre().x;
}

uint32_t normalWord(dvec3 n) {
    uint32_t word = 0xff000000u;
    for (int c = 0; c < 3; c++) word |= static_cast<uint32_t>(std::lround((n[c] * 0.5 + 0.5) * 255.0)) << (8 * c);
    return word;
}

TEST(Look, NormalMapsTiltTheSurface) {
    const vec3 suns[] = {
        {0, 0, 1}, glm::normalize(vec3(1, 0, 1)), glm::normalize(vec3(0, 1, 1)), glm::normalize(vec3(-1, 0.5f, 2))};
    const dvec3 tilts[] = {
        {0, 0, 1}, glm::normalize(dvec3(0.5, 0, 1)), glm::normalize(dvec3(0, 0.5, 1)), glm::normalize(dvec3(-0.3, 0.6, 1))};
    for (dvec3 tilt : tilts) {
        const ImageData image = imageOf(1, 1, false, {normalWord(tilt)});
        for (vec3 s : suns) {
            // glTF: red along +u, green up the image, which is +y on the poster.
            EXPECT_NEAR(litShare(image, false, 1.0f, s), std::max(0.0, glm::dot(tilt, dvec3(s))), 0.01)
                << tilt.x << ' ' << tilt.y;
            EXPECT_NEAR(litShare(image, false, 1.0f, s, true), std::max(0.0, glm::dot(tilt, dvec3(s))), 0.01) << "placed";
            const dvec3 turned(-tilt.x, tilt.y, tilt.z);  // the poster mirrored in x
            EXPECT_NEAR(litShare(image, false, 1.0f, s, false, true), std::max(0.0, glm::dot(turned, dvec3(s))), 0.01)
                << "mirrored";
            EXPECT_NEAR(litShare(image, false, 1.0f, s, true, true), std::max(0.0, glm::dot(turned, dvec3(s))), 0.01)
                << "mirrored, placed";
        }
    }
}

TEST(Look, NormalScaleFlattensTheTilt) {
    const ImageData image = imageOf(1, 1, false, {normalWord(glm::normalize(dvec3(0.5, 0, 1)))});
    const vec3 s = glm::normalize(vec3(1, 0, 1));
    EXPECT_NEAR(litShare(image, false, 0.0f, s), std::sqrt(0.5), 0.005);
    EXPECT_NEAR(litShare(image, false, 0.5f, s), glm::dot(glm::normalize(dvec3(0.25, 0, 1)), dvec3(s)), 0.01);
}

// Heights that grow to the right: the surface leans to the left. Up the image likewise.
TEST(Look, BumpMapsLeanAwayFromTheHigherSide) {
    std::vector<uint32_t> right, up;
    for (uint32_t y = 0; y < 32; y++) {
        for (uint32_t x = 0; x < 32; x++) {
            right.push_back(0xff000000u | (x * 8) * 0x010101u);
            up.push_back(0xff000000u | ((31 - y) * 8) * 0x010101u);
        }
    }
    const vec3 left = glm::normalize(vec3(-1, 0, 1)), down = glm::normalize(vec3(0, -1, 1));
    const ImageData rising = imageOf(32, 32, false, right), climbing = imageOf(32, 32, false, up);
    EXPECT_GT(litShare(rising, true, 1.0f, left), litShare(rising, true, 1.0f, vec3(-left.x, 0, left.z)) + 0.05);
    EXPECT_GT(litShare(climbing, true, 1.0f, down), litShare(climbing, true, 1.0f, vec3(0, -down.y, down.z)) + 0.05);
    EXPECT_NEAR(litShare(rising, true, 1.0f, vec3(0, 1, 1) * std::sqrt(0.5f)), litShare(rising, true, 1.0f, down), 0.01);
}

// A mirror under a normal map of 80 degrees: every reflection still leaves the surface, so no energy is lost or made.
TEST(Look, SteepNormalsOnAMirrorStayInTheFurnace) {
    SceneBuilder builder = darkness(vec3(1.0f));
    Material m = mirror(1.0f);
    const double a = 80.0 * EXACT_PI / 180.0;
    m.normalTexture = builder.addTexture(
        SceneBuilder::defaultTexture(builder.addImage(imageOf(1, 1, false, {normalWord({std::sin(a), 0, std::cos(a)})}))));
    place(builder, poster(builder.addMaterial(m, "relief")));
    const auto scene = builder.finish();
    for (vec3 eye : {vec3(0, 0, 4), vec3(4, 0, 0.5f), vec3(-4, 0, 0.5f)}) {
        const Picture picture = render(scene, lookAt(eye, vec3(0.0f), 20.0f));
        for (vec4 p : picture.pixels) ASSERT_NEAR(p.x, 1.0f, 1e-4f);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

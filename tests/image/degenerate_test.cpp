// Geometry that files really hold: no picture of it may have a sample that is not a number.

#include "tests/image/picture.h"
#include "tests/support/random.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <limits>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

constexpr float INFINITE = std::numeric_limits<float>::infinity();
constexpr float NOT_A_NUMBER = std::numeric_limits<float>::quiet_NaN();

Settings everything() {
    Settings settings;
    settings.ambientOcclusion = true;
    settings.aoSamples = 4;
    settings.maxReflections = 4;
    settings.contributionThreshold = 0.0f;
    return settings;
}

/// A mirror, a glass and a painted copy of a mesh, lit.
std::shared_ptr<const Scene> threeOf(MeshData mesh) {
    SceneBuilder builder = darkness(vec3(0.5f));
    Material half = mirror(0.5f);
    half.baseColor = vec4(0.5f, 0.5f, 0.5f, 1.0f);
    const Material materials[] = {half, glass(1.5f), SceneBuilder::defaultMaterial()};
    for (int i = 0; i < 3; i++) {
        mesh.materials.assign(mesh.indices.size(), builder.addMaterial(materials[i], "kind"));
        place(builder, mesh, glm::translate(mat4(1.0f), vec3(2.2f * float(i - 1), 0, 0)));
    }
    builder.addLight(pointLight(vec3(1, 4, 3), vec3(30.0f)));
    return builder.finish();
}

void expectFinite(const std::shared_ptr<const Scene>& scene, const char* what) {
    const Picture picture = render(scene, lookAt(vec3(0.1f, 0.7f, 7), vec3(0.0f)), everything());
    EXPECT_EQ(picture.stats.nonfiniteSamples, 0u) << what;
    for (vec4 p : picture.pixels) ASSERT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) << what;
}

TEST(Degenerate, SliversAndTrianglesWithoutAreaGiveFinitePictures) {
    Random random(1);
    MeshData mesh = icosphere(2);
    const auto add = [&](vec3 a, vec3 b, vec3 c) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {a, b, c});
        mesh.normals.insert(mesh.normals.end(), {vec3(0, 1, 0), vec3(0, 1, 0), vec3(0, 1, 0)});
        mesh.indices.push_back({first, first + 1, first + 2});
    };
    for (int i = 0; i < 2000; i++) {
        const vec3 a = random.inCube(1.0f), d = random.direction();
        add(a, a + d, a + d * 0.5f);  // collinear
        add(a, a, a + d);             // two corners in one place
        add(a, a, a);
        add(a, a + d, a + d + random.direction() * 1e-7f);  // aspect 1e7
    }
    for (uint32_t i = 0; i < 100; i++) mesh.indices.push_back({i, i, i + 1});
    expectFinite(threeOf(mesh), "slivers");
}

TEST(Degenerate, TrianglesWithoutAreaChangeNoPixel) {
    const MeshData clean = icosphere(3);
    MeshData dirty = clean;
    Random random(2);
    for (int i = 0; i < 10000; i++) {
        const auto first = static_cast<uint32_t>(dirty.positions.size());
        const vec3 p = random.inCube(2.0f);
        dirty.positions.insert(dirty.positions.end(), {p, p, p});
        dirty.normals.insert(dirty.normals.end(), 3, vec3(0, 1, 0));
        dirty.indices.push_back({first, first + 1, first + 2});
    }
    const Camera camera = lookAt(vec3(0.1f, 0.7f, 7), vec3(0.0f));
    Settings settings;
    settings.robust = true;
    const Picture a = render(threeOf(clean), camera, settings), b = render(threeOf(dirty), camera, settings);
    int different = 0;
    for (size_t i = 0; i < a.pixels.size(); i++) different += vec3(a.pixels[i]) != vec3(b.pixels[i]);
    EXPECT_EQ(different, 0);
}

TEST(Degenerate, BadNormalsAreReplaced) {
    MeshData mesh = icosphere(3);
    for (size_t i = 0; i < mesh.normals.size(); i += 3) mesh.normals[i] = vec3(0.0f);
    for (size_t i = 1; i < mesh.normals.size(); i += 3) mesh.normals[i] = vec3(NOT_A_NUMBER, 1.0f, 0.0f);
    for (size_t i = 2; i < mesh.normals.size(); i += 6) mesh.normals[i] = vec3(INFINITE, 0.0f, 0.0f);
    const auto scene = threeOf(mesh);
    EXPECT_FALSE(scene->warnings.empty()) << "said, not hidden";
    expectFinite(scene, "normals");
}

TEST(Degenerate, BadPositionsDropTheirTrianglesOnly) {
    MeshData mesh = icosphere(3);
    mesh.positions[5] = vec3(NOT_A_NUMBER);
    mesh.positions[9].y = INFINITE;
    mesh.positions[30] = vec3(1e30f);
    const auto scene = threeOf(mesh);
    EXPECT_FALSE(scene->warnings.empty());
    expectFinite(scene, "positions");
}

TEST(Degenerate, BadCoordinatesAndTangentsGiveFinitePictures) {
    SceneBuilder builder = darkness(vec3(0.5f));
    ImageData image;
    image.width = image.height = 4;
    Random random(3);
    for (int i = 0; i < 64; i++) image.rgba8.push_back(static_cast<uint8_t>(random.below(256)));
    image.srgb = false;
    Material m = SceneBuilder::defaultMaterial();
    m.baseTexture = m.normalTexture = builder.addTexture(SceneBuilder::defaultTexture(builder.addImage(image)));
    MeshData mesh = icosphere(3, builder.addMaterial(m, "relief"));
    const float values[] = {0.0f, 1.0f, NOT_A_NUMBER, INFINITE, 1e30f, -1e30f, 1e6f, 1e-40f};
    for (size_t i = 0; i < mesh.positions.size(); i++) {
        mesh.uv0.emplace_back(values[i % 8], values[(i / 3) % 8]);
        mesh.tangents.emplace_back(i % 2 ? vec4(0.0f) : vec4(NOT_A_NUMBER, 1, 0, i % 4 ? 2.0f : 0.0f));
    }
    place(builder, mesh);
    builder.addLight(pointLight(vec3(1, 4, 3), vec3(30.0f)));
    expectFinite(builder.finish(), "coordinates");
}

TEST(Degenerate, FlattenedAndTinyInstancesGiveFinitePictures) {
    for (vec3 scale :
         {vec3(1, 0, 1), vec3(1, 1, 0), vec3(0, 0, 0), vec3(1, 0, 0), vec3(1e-3f, 1, 1e3f), vec3(1e-20f, 1e-20f, 1e-20f)}) {
        for (bool placed : {false, true}) {
            SceneBuilder builder = darkness(vec3(0.5f));
            Material half = mirror(0.5f);
            half.baseColor = vec4(0.5f, 0.5f, 0.5f, 1.0f);
            const uint32_t mesh = builder.addMesh(icosphere(2, builder.addMaterial(half, "half")));
            builder.addInstance(mesh, glm::scale(mat4(1.0f), scale));
            if (placed) builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(3, 0, 0)));
            builder.addLight(pointLight(vec3(1, 4, 3), vec3(30.0f)));
            expectFinite(builder.finish(), "scale");
        }
    }
}

TEST(Degenerate, LightsAndCamerasOnTheSurfaceGiveFinitePictures) {
    SceneBuilder builder = darkness(vec3(0.5f));
    place(builder, ground(3.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
    place(builder, icosphere(2, builder.addMaterial(glass(1.5f), "glass")));
    builder.addLight(pointLight(vec3(0.5f, 0.0f, 1.5f), vec3(1.0f)));    // exactly on the floor
    builder.addLight(pointLight(vec3(-0.5f, 1e-6f, 1.5f), vec3(1.0f)));  // just above it
    const auto scene = builder.finish();
    expectFinite(scene, "lights");
    for (vec3 eye : {vec3(0, 0, 2), vec3(0, 0, 0), vec3(0, 1, 0)}) {
        const Picture picture = render(scene, lookAt(eye, eye + vec3(0.1f, -0.2f, -1.0f), 60.0f), everything());
        EXPECT_EQ(picture.stats.nonfiniteSamples, 0u);
    }
}

// Two walls in one place: the first is seen everywhere, whatever traces it.
TEST(Degenerate, OfTwoWallsInOnePlaceTheFirstIsSeen) {
    SceneBuilder builder = darkness(vec3(1.0f));
    place(builder,
          panel(vec3(-3, -3, 0.1f), vec3(6, 0, 1), vec3(0, 6, 0.5f), builder.addMaterial(paint(vec3(1, 0, 0)), "red")));
    place(builder,
          panel(vec3(-3, -3, 0.1f), vec3(6, 0, 1), vec3(0, 6, 0.5f), builder.addMaterial(paint(vec3(0, 1, 0)), "green")));
    const auto scene = builder.finish();
    for (bool packets : {false, true}) {
        Settings settings;
        settings.primaryPackets = packets;
        const Picture picture = render(scene, lookAt(vec3(0, 0, 4), vec3(0.0f)), settings);
        for (vec4 p : picture.pixels) ASSERT_TRUE(p.x > 0.5f && p.y == 0.0f);
    }
}

// A power of two scales every quantity exactly, so the picture is the same bit for bit.
TEST(Degenerate, TinyAndHugeWorldsLookTheSame) {
    const auto picture = [](float scale, bool placed) {
        SceneBuilder builder = darkness(vec3(0.5f));
        const mat4 m = glm::scale(mat4(1.0f), vec3(scale));
        place(builder, ground(6.0f, builder.addMaterial(paint(vec3(0.8f)), "white"), -1.0f), m);
        const uint32_t ball = builder.addMesh(icosphere(3, builder.addMaterial(glass(1.5f), "glass")));
        builder.addInstance(ball, m);
        if (placed) builder.addInstance(ball, m * glm::translate(mat4(1.0f), vec3(2.5f, 0.25f, -1.0f)));
        builder.addLight(pointLight(vec3(2, 4, 3) * scale, vec3(30.0f) * scale * scale));
        const Picture p = render(builder.finish(), lookAt(vec3(0, 1, 6) * scale, vec3(0.0f)), everything());
        EXPECT_EQ(p.stats.nonfiniteSamples, 0u) << scale;
        return p.pixels;
    };
    for (bool placed : {false, true}) {
        const auto usual = picture(2.0f, placed);  // at 1 the first ball is where its mesh has it, which takes other arithmetic
        for (int exponent = -40; exponent <= 40; exponent += 5) {
            const auto scaled = picture(std::ldexp(1.0f, exponent), placed);
            size_t different = 0;
            double sum = 0.0, usualSum = 0.0;
            for (size_t i = 0; i < usual.size(); i++) {
                different += scaled[i] != usual[i];
                sum += scaled[i].x, usualSum += usual[i].x;
            }
            EXPECT_NEAR(sum / usualSum, 1.0, 0.005) << placed << " 2^" << exponent;
            // Beyond that a device's own products leave what float holds.
            const bool exact = exponent >= -35 && exponent <= 30 && exponent != 0;
            EXPECT_EQ(exact ? different : 0u, 0u) << placed << " 2^" << exponent;
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

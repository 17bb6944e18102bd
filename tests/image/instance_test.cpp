#include "tests/image/picture.h"
#include "tests/support/random.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

/// A body of colourful facets: each triangle has a colour of its own, so colours tell which one was hit.
MeshData facets(SceneBuilder& builder) {
    Random random(1);
    const MeshData smooth = icosphere(2);
    MeshData mesh;
    for (uvec3 t : smooth.indices) {
        const uint32_t material =
            builder.addMaterial(glow(vec3(random.real(0, 1), random.real(0, 1), random.real(0, 1))), "facet");
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (int k = 0; k < 3; k++) mesh.positions.push_back(smooth.positions[t[k]]);
        mesh.indices.push_back({first, first + 1, first + 2});
        mesh.materials.push_back(material);
    }
    return mesh;
}

std::vector<mat4> placements() {
    const mat4 one(1.0f);
    mat4 shear(1.0f);
    shear[1][0] = 0.8f;
    return {glm::translate(one, vec3(0.3f, -0.2f, 0.1f)), glm::rotate(one, 1.1f, glm::normalize(vec3(1, 2, 3))),
            glm::scale(one, vec3(1.3f, 0.6f, 0.9f)), glm::scale(one, vec3(-1, 1, 1)),
            glm::scale(shear, vec3(0.7f, -0.9f, -1.0f))};
}

/// The body under `toWorld`, as an instance of a mesh used twice or baked by itself.
template <typename Fill>
std::shared_ptr<const Scene> placedScene(const mat4& toWorld, bool instanced, const Fill& fill) {
    SceneBuilder builder = darkness(vec3(0.2f));
    const uint32_t mesh = builder.addMesh(fill(builder));
    builder.addInstance(mesh, toWorld);
    if (instanced) builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(500.0f)));
    builder.addLight(pointLight(vec3(2, 3, 4), vec3(40.0f)));
    return builder.finish();
}

TEST(Instances, HitTheSameTrianglesAsABakedMesh) {
    for (const mat4& m : placements()) {
        const Camera camera = lookAt(vec3(0.5f, 0.4f, 4), vec3(0.0f));
        const auto instanced = placedScene(m, true, facets), baked = placedScene(m, false, facets);
        ASSERT_NE(instanced->instances[0].flags & INSTANCE_IDENTITY, baked->instances[0].flags & INSTANCE_IDENTITY);
        const Picture a = render(instanced, camera), b = render(baked, camera);
        int different = 0;
        for (size_t i = 0; i < a.pixels.size(); i++) different += a.pixels[i] != b.pixels[i];
        EXPECT_LE(different, 2) << "rays along an edge may fall to either side";
    }
}

TEST(Instances, AreShadedAsABakedMesh) {
    const auto smooth = [](SceneBuilder& builder) {
        Material m = SceneBuilder::defaultMaterial();
        m.baseColor = vec4(0.8f, 0.5f, 0.3f, 1.0f);
        m.roughness = 0.5f;
        return icosphere(3, builder.addMaterial(m, "paint"));
    };
    for (const mat4& m : placements()) {
        const Camera camera = lookAt(vec3(0.5f, 0.4f, 4), vec3(0.0f));
        const Picture a = render(placedScene(m, true, smooth), camera), b = render(placedScene(m, false, smooth), camera);
        int different = 0;
        for (size_t i = 0; i < a.pixels.size(); i++) {
            const float bright = std::max(1.0f, std::max(a.pixels[i].x, b.pixels[i].x));
            different += glm::length(vec3(a.pixels[i]) - vec3(b.pixels[i])) > 1e-3f * bright;
        }
        EXPECT_LE(different, 8) << "terminator and silhouette pixels";
    }
}

// Half of a sphere's light, mirrored: the picture of the mirrored sphere under a mirrored light, pixel for pixel.
TEST(Instances, MirroredOnesAreLitOnTheOutside) {
    for (bool instanced : {false, true}) {
        SceneBuilder builder = darkness();
        const uint32_t mesh = builder.addMesh(icosphere(4, builder.addMaterial(paint(vec3(1.0f)), "white")));
        builder.addInstance(mesh, glm::scale(mat4(1.0f), vec3(1, 1, -1)));
        if (instanced) builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(500.0f)));
        builder.addLight(sun(vec3(0, 0, -1), vec3(float(EXACT_PI))));
        const Camera camera = lookAt(vec3(0, 0, 4), vec3(0.0f));
        const Picture picture = render(builder.finish(), camera);
        for (uint32_t y = 0; y < picture.size.y; y += 2) {
            for (uint32_t x = 0; x < picture.size.x; x += 2) {
                const dvec3 d = rayThrough(camera, picture.size, x, y), o(camera.position);
                const double t = meetsUnitSphere(o, d);
                if (t < 0.0 || (o + d * t).z < 0.2) continue;
                ASSERT_NEAR(picture.at(x, y).x, (o + d * t).z, 0.01);
            }
        }
    }
}

TEST(Instances, CastAndReceiveShadows) {
    SceneBuilder builder = darkness();
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    const uint32_t slab = builder.addMesh(panel(vec3(-0.5f, 0, 0.5f), vec3(1, 0, 0), vec3(0, 0, -1), white));
    builder.addInstance(slab, glm::translate(glm::scale(mat4(1.0f), vec3(1, 2, 1)), vec3(0, 1, 0)));
    builder.addInstance(slab, glm::scale(mat4(1.0f), vec3(20, 1, 20)));
    builder.addLight(sun(vec3(0, -1, 0), vec3(float(EXACT_PI))));
    const Camera camera = lookAt(vec3(0, 1.5f, 4), vec3(0.0f), 50.0f);
    const Picture picture = render(builder.finish(), camera);
    int dark = 0;
    for (uint32_t y = 50; y < picture.size.y; y++) {
        for (uint32_t x = 0; x < picture.size.x; x++) {
            const dvec3 p = onPlane(camera, picture.size, x, y, dvec3(0.0), dvec3(0, 1, 0));
            const double edge = std::max(std::abs(p.x), std::abs(p.z)) - 0.5;
            if (std::abs(edge) < 1e-3 || std::max(std::abs(p.x), std::abs(p.z)) > 9.9) continue;
            ASSERT_NEAR(picture.at(x, y).x, edge < 0.0 ? 0.0f : 1.0f, 1e-5f) << x << ' ' << y;
            dark += edge < 0.0;
        }
    }
    EXPECT_GT(dark, 50);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "tests/kernel/kernel_access.h"

#include "server/scene/kernel_tables.h"
#include "tests/support/bodies.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <functional>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using glm::dmat3;
using glm::mat4;

EveryKernel kernelFor(const Scene& scene) {
    EveryKernel kernel = bareKernel();
    kernel.scene = sceneView(scene);
    kernel.frame.effects &= ~EFFECT_TANGENTS;  // none are stored
    return kernel;
}

/// The mesh once with `toWorld`; a second copy far away keeps it in object space if `placed`.
std::shared_ptr<const Scene> sceneOf(MeshData mesh, const mat4& toWorld, bool placed) {
    SceneBuilder builder("one body");
    const uint32_t index = builder.addMesh(std::move(mesh));
    builder.addInstance(index, toWorld);
    if (placed) builder.addInstance(index, glm::translate(mat4(1.0f), vec3(1000.0f)));
    return builder.finish();
}

/// World position of a corner as double arithmetic has it.
dvec3 corner(const Scene& scene, uint32_t instance, uint32_t primitive, int k) {
    const Instance& i = scene.instances[instance];
    const dvec3 p(vec3(scene.positions[scene.triangles[i.firstTriangle + primitive][k]]));
    const auto row = [&](vec4 r) { return r.x * p.x + r.y * p.y + r.z * p.z + r.w; };
    return {row(i.toWorld0), row(i.toWorld1), row(i.toWorld2)};
}

struct Case {
    const char* name;
    mat4 matrix;
};

std::vector<Case> transforms() {
    const mat4 one(1.0f);
    mat4 deep(1.0f);
    for (int i = 0; i < 40; i++)
        deep = glm::rotate(glm::translate(deep, vec3(0.1f, -0.05f, 0.02f)), 0.37f, glm::normalize(vec3(1, i % 3, 2)));
    mat4 shear(1.0f);
    shear[1][0] = 1.7f;
    shear[2][1] = -0.6f;
    return {{"rotation", glm::rotate(one, 1.0f, glm::normalize(vec3(1, 2, 3)))},
            {"mirrored", glm::scale(one, vec3(1, 1, -1))},
            {"point reflection", glm::scale(one, vec3(-1, -1, -1))},
            {"very uneven", glm::scale(one, vec3(1e-3f, 1, 1e3f))},
            {"sheared", shear},
            {"sheared and mirrored", glm::scale(shear, vec3(-2, 3, 0.5f))},
            {"forty deep", deep},
            {"far away", glm::translate(one, vec3(1e5f, -3e4f, 2e5f))}};
}

/// Compares position, both normals and side of random hits with double arithmetic.
void checkTransform(const Case& c, bool placed) {
    const MeshData body = icosphere(2);
    const auto scene = sceneOf(body, c.matrix, placed);
    EveryKernel kernel = kernelFor(*scene);
    const dmat3 linear = dmat3(glm::dmat4(c.matrix));
    const double determinant = glm::determinant(linear);
    // Cofactor matrix: the inverse transpose times the determinant.
    const dmat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]), glm::cross(linear[0], linear[1]));
    Random random(1);
    for (int i = 0; i < 2000; i++) {
        const uint32_t primitive = random.below(static_cast<uint32_t>(body.indices.size()));
        double u = random.number(0.1, 0.4), v = random.number(0.1, 0.4), w = 1.0 - u - v;
        const dvec3 a = corner(*scene, 0, primitive, 0), b = corner(*scene, 0, primitive, 1),
                    d = corner(*scene, 0, primitive, 2);
        const dvec3 target = a * w + b * u + d * v;
        const bool outside = random.below(2) != 0;
        // Outer side of the facet in world space: away from the body's centre, whatever the transform.
        dvec3 outer = glm::normalize(glm::cross(b - a, d - a));
        if (glm::dot(outer, target - dvec3(c.matrix[3])) < 0.0) outer = -outer;
        const double size = std::max({glm::length(b - a), glm::length(d - a), glm::length(dvec3(target)) * 1e-3});
        const vec3 origin(target + outer * (outside ? size : -size) +
                          glm::cross(outer, dvec3(random.direction())) * (0.3 * size));
        const vec3 direction = vec3(glm::normalize(target - dvec3(origin)));
        const auto s = kernel.surfaceAt(origin, direction, 0.0f, 0.0f, Hit{0, primitive});
        const double reach = std::max({glm::length(a), glm::length(b), glm::length(d), glm::length(dvec3(origin))});
        ASSERT_LT(std::abs(glm::dot(dvec3(s.position) - target, outer)), 3e-6 * reach) << c.name;
        // Where along their length a ray meets triangles a million times as long as wide is not well defined.
        if (c.name != std::string("very uneven")) {
            ASSERT_LT(glm::length(dvec3(s.position) - target), 3e-6 * reach) << c.name;
        }
        ASSERT_EQ(s.side, outside ? 1.0f : -1.0f) << c.name;
        // World-space corners are rounded: the facet turns by that over its least height.
        const double longest = std::max({glm::length(b - a), glm::length(d - a), glm::length(d - b)});
        const double height = glm::length(glm::cross(b - a, d - a)) / longest;
        ASSERT_LT(glm::length(dvec3(s.geometricNormal) - outer * double(s.side)), 4e-7 * reach / height + 1e-6) << c.name;
        // Object-space normals of the corners, carried over and interpolated at the place that the kernel has found.
        const vec3 first =
            kernel.transformPoint(0, vec3(scene->positions[scene->triangles[scene->instances[0].firstTriangle + primitive].x]));
        const auto bary = kernel.triangleBarycentrics(origin, direction, first, s.edge1, s.edge2);
        u = bary.u, v = bary.v, w = 1.0 - u - v;
        const uvec3 t = body.indices[primitive];
        dvec3 exact(0.0);
        // Baked meshes with a mirrored transform swap two corners: find them by position.
        for (int k = 0; k < 3; k++) {
            const dvec3 at = dvec3(vec3(c.matrix * vec4(body.positions[t[k]], 1.0f)));
            const double da = glm::length(at - a), db = glm::length(at - b), dd = glm::length(at - d);
            const double weight = da <= db && da <= dd ? w : db <= dd ? u : v;
            const dvec3 n = glm::normalize(cofactor * dvec3(body.normals[t[k]])) * (determinant < 0.0 ? -1.0 : 1.0);
            exact += n * weight;
        }
        exact = glm::normalize(exact) * double(s.side);
        if (glm::dot(exact, outer * double(s.side)) < 0.01) continue;  // the facet's own serves there
        const double angle = std::atan2(glm::length(glm::cross(exact, dvec3(s.normal))), glm::dot(exact, dvec3(s.normal)));
        ASSERT_LT(angle * 180.0 / EXACT_PI, 0.01) << c.name;
    }
}

TEST(Surface, TransformedNormalsMatchDouble) {
    for (const Case& c : transforms()) {
        checkTransform(c, true);
        if (HasFatalFailure()) return;
    }
}

TEST(Surface, BakedNormalsMatchDouble) {
    for (const Case& c : transforms()) {
        checkTransform(c, false);
        if (HasFatalFailure()) return;
    }
}

TEST(Surface, AScaleOfZeroLeavesAFlatBodyWithItsNormal) {
    const auto scene = sceneOf(icosphere(2), glm::scale(mat4(1.0f), vec3(1, 0, 1)), true);
    EveryKernel kernel = kernelFor(*scene);
    const vec3 origin(0.1f, 3.0f, 0.2f), direction(0.0f, -1.0f, 0.0f);
    uint32_t flat = NO_INDEX;
    for (uint32_t i = 0; i < scene->instances.size(); i++)
        if (scene->instances[i].flags & INSTANCE_IDENTITY) flat = i;
    ASSERT_NE(flat, NO_INDEX) << "baked: there is no inverse";
    for (uint32_t p = 0; p < scene->meshes[scene->instances[flat].mesh].triangleCount; p++) {
        const auto s = kernel.surfaceAt(origin, direction, 0.0f, 0.0f, Hit{flat, p});
        ASSERT_TRUE(kernel.isFinite3(s.position) && kernel.isFinite3(s.normal) && kernel.isFinite3(s.shadowPosition));
        ASSERT_EQ(s.position.y, 0.0f);
        if (s.geometricNormal == vec3(0.0f)) continue;  // triangles seen edge-on before they were flattened
        ASSERT_NEAR(std::abs(s.geometricNormal.y), 1.0f, 1e-6f);
        ASSERT_NEAR(std::abs(s.normal.y), 1.0f, 1e-6f);
    }
}

TEST(Surface, AScaleOfZeroInAllDirectionsIsLeftOutAndSaid) {
    SceneBuilder builder("nothing");
    const uint32_t mesh = builder.addMesh(icosphere(1));
    builder.addInstance(mesh, glm::scale(mat4(1.0f), vec3(0.0f)));
    const auto scene = builder.finish();
    EXPECT_TRUE(scene->instances.empty());
    EXPECT_FALSE(scene->warnings.empty());
}

TEST(Surface, ANormalThatLooksAwayIsReplacedByTheFacets) {
    MeshData mesh = panel(vec3(0.0f), vec3(1, 0, 0), vec3(0, 1, 0));
    for (vec3& n : mesh.normals) n = vec3(0.0f, 0.6f, -0.8f);
    const auto scene = sceneOf(mesh, mat4(1.0f), false);
    EveryKernel kernel = kernelFor(*scene);
    const auto s = kernel.surfaceAt(vec3(0.6f, 0.3f, 2.0f), vec3(0, 0, -1), 0.0f, 0.0f, Hit{0, 0});
    EXPECT_EQ(s.normal, s.geometricNormal);
    EXPECT_EQ(s.normal, vec3(0, 0, 1));
}

// However far the eye is: a ray that goes on starts off the facet by the clearance, which knows nothing of the eye.
TEST(Surface, APointSeenFromAfarLiesOnItsFacet) {
    const auto scene = sceneOf(icosphere(2), mat4(1.0f), false);
    EveryKernel kernel = kernelFor(*scene);
    Random random(3);
    for (int i = 0; i < 20000; i++) {
        const uint32_t primitive = random.below(320);
        const dvec3 a = corner(*scene, 0, primitive, 0), b = corner(*scene, 0, primitive, 1),
                    c = corner(*scene, 0, primitive, 2);
        const dvec3 target = (a + b + c) / 3.0;
        vec3 away = random.direction();
        if (glm::dot(dvec3(away), target) < 0.0) away = -away;
        const vec3 origin = vec3(target) + away * static_cast<float>(random.magnitude(1.0, 1e4));
        const vec3 direction = vec3(glm::normalize(target - dvec3(origin)));
        const auto s = kernel.surfaceAt(origin, direction, 0.0f, 0.0f, Hit{0, primitive});
        const dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
        ASSERT_LT(std::abs(glm::dot(dvec3(s.position) - a, normal)), double(s.clearance));
    }
}

TEST(Surface, InterpolatesColoursAndCoordinatesLinearly) {
    MeshData mesh = panel(vec3(0.0f), vec3(2, 0, 0), vec3(0, 3, 0));
    mesh.colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}, {1, 1, 1, 0}};
    mesh.uv1 = {{5, 5}, {6, 5}, {6, 7}, {5, 7}};
    const auto scene = sceneOf(mesh, mat4(1.0f), false);
    EveryKernel kernel = kernelFor(*scene);
    const auto s = kernel.surfaceAt(vec3(1.5f, 0.75f, 1.0f), vec3(0, 0, -1), 0.0f, 0.0f, Hit{0, 0});
    EXPECT_NEAR(s.uv0.x, 0.75f, 1e-6f);
    EXPECT_NEAR(s.uv0.y, 0.25f, 1e-6f);
    EXPECT_NEAR(s.uv1.x, 5.75f, 1e-5f);
    EXPECT_NEAR(s.uv1.y, 5.5f, 1e-5f);
    EXPECT_NEAR(s.color.x, 0.25f, 1e-6f);
    EXPECT_NEAR(s.color.y, 0.5f, 1e-6f);
    EXPECT_NEAR(s.color.z, 0.25f, 1e-6f);
    EXPECT_NEAR(s.distance, 1.0f, 1e-6f);
}

// A cone of width 0.01 that meets a panel of 2 x 3 metres under uv 1 x 1: its area over the panel's, stretched by 1 / cosine.
TEST(Surface, FootprintIsTheConesShareOfTheTexture) {
    const auto scene = sceneOf(panel(vec3(0.0f), vec3(2, 0, 0), vec3(0, 3, 0)), mat4(1.0f), false);
    EveryKernel kernel = kernelFor(*scene);
    const auto straight = kernel.surfaceAt(vec3(1.0f, 0.5f, 4.0f), vec3(0, 0, -1), 0.002f, 0.002f, Hit{0, 0});
    EXPECT_NEAR(straight.footprint.x / (0.01 * 0.01 / 6.0), 1.0, 1e-5);
    const vec3 slanted = glm::normalize(vec3(0.0f, 1.0f, -1.0f));
    const auto s = kernel.surfaceAt(vec3(1.0f, 0.5f, 1.0f) - slanted * 0.0f, slanted, 0.01f, 0.0f, Hit{0, 0});
    EXPECT_NEAR(s.footprint.x / (0.01 * 0.01 / 6.0 * std::sqrt(2.0)), 1.0, 1e-5);
    const auto grazing =
        kernel.surfaceAt(vec3(1.0f, 0.5f, 1e-4f), glm::normalize(vec3(0.0f, 1.0f, -1e-4f)), 0.01f, 0.0f, Hit{0, 0});
    EXPECT_TRUE(std::isfinite(grazing.footprint.x));
}

// 64 steps of a colour stay 64, also where eight linear bits have two.
TEST(Surface, ColoursOfVerticesKeepSixteenBits) {
    for (const float most : {0.01f, 0.1f, 1.0f}) {
        float before = -1.0f;
        for (int step = 0; step < 64; step++) {
            const float level = most * float(step) / 63.0f;
            MeshData mesh = panel(vec3(0.0f), vec3(2, 0, 0), vec3(0, 3, 0));
            mesh.colors.assign(4, vec4(level, most - level, level, 1.0f));
            const auto scene = sceneOf(mesh, mat4(1.0f), step % 2 == 0);
            const auto s = kernelFor(*scene).surfaceAt(vec3(1.5f, 0.75f, 1.0f), vec3(0, 0, -1), 0.0f, 0.0f, Hit{0, 0});
            EXPECT_NEAR(s.color.x, level, 1e-5f);
            EXPECT_NEAR(s.color.y, most - level, 1e-5f);
            EXPECT_NEAR(s.color.z, level, 1e-5f);
            EXPECT_EQ(s.color.w, 1.0f);
            EXPECT_GT(s.color.x, before);
            before = s.color.x;
        }
    }
    // What eight bits hold has no rest.
    MeshData mesh = panel(vec3(0.0f), vec3(2, 0, 0), vec3(0, 3, 0));
    for (int i = 0; i < 4; i++) mesh.colors.push_back(vec4(float(10 * i), 255.0f, float(i), 128.0f) / 255.0f);
    const auto scene = sceneOf(mesh, mat4(1.0f), false);
    for (const vec4& position : scene->positions) EXPECT_EQ(position.w, 0.0f);
}

// Either set of coordinates has a footprint of its own.
TEST(Surface, TheSecondCoordinatesHaveTheirOwnFootprint) {
    MeshData mesh = panel(vec3(0.0f), vec3(2, 0, 0), vec3(0, 3, 0));
    mesh.uv1 = mesh.uv0;
    for (vec2& uv : mesh.uv0) uv *= 200.0f;
    const auto scene = sceneOf(mesh, mat4(1.0f), false);
    EveryKernel kernel = kernelFor(*scene);
    const auto s = kernel.surfaceAt(vec3(1.0f, 0.5f, 4.0f), vec3(0, 0, -1), 0.002f, 0.002f, Hit{0, 0});
    EXPECT_NEAR(s.footprint.x / (0.01 * 0.01 / 6.0 * 40000.0), 1.0, 1e-4);
    EXPECT_NEAR(s.footprint.y / (0.01 * 0.01 / 6.0), 1.0, 1e-4);
}

// ---- the shadow terminator ----

bool blocked(const MeshData& mesh, dvec3 origin, dvec3 direction, double tMax) {
    for (uvec3 t : mesh.indices) {
        const dvec3 a(mesh.positions[t.x]), e1 = dvec3(mesh.positions[t.y]) - a, e2 = dvec3(mesh.positions[t.z]) - a;
        const dvec3 p = glm::cross(direction, e2), s = origin - a;
        const double det = glm::dot(e1, p), u = glm::dot(s, p) / det;
        const dvec3 q = glm::cross(s, e1);
        const double v = glm::dot(direction, q) / det, distance = glm::dot(e2, q) / det;
        if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0 && distance < tMax) return true;
    }
    return false;
}

struct TerminatorError {
    double mean, worst;
};

/// Error of N.L with shadows against the true sphere, over points where the light stands at 60 to 90 degrees.
TerminatorError terminatorError(bool mitigated) {
    const MeshData body = icosphere(2);
    SceneBuilder builder("terminator");
    builder.addInstance(builder.addMesh(body), mat4(1.0f));
    Light light{};
    light.position = vec3(0.0f, 0.0f, 50.0f);
    light.direction = vec3(0, 0, -1);
    light.intensity = vec3(2500.0f);
    builder.addLight(light);
    const auto scene = builder.finish();
    EveryKernel kernel = kernelFor(*scene);
    Random random(1);
    double error = 0.0, worst = 0.0;
    int count = 0;
    for (int i = 0; i < 30000; i++) {
        const uint32_t primitive = random.below(static_cast<uint32_t>(body.indices.size()));
        const uvec3 t = body.indices[primitive];
        double u = random.number(0.0, 1.0), v = random.number(0.0, 1.0);
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        const dvec3 target =
            dvec3(body.positions[t.x]) * (1.0 - u - v) + dvec3(body.positions[t.y]) * u + dvec3(body.positions[t.z]) * v;
        const dvec3 trueNormal = glm::normalize(target);
        const dvec3 toLight = dvec3(light.position) - trueNormal;
        const double cosine = glm::dot(trueNormal, glm::normalize(toLight));
        if (cosine < 0.0 || cosine > 0.5) continue;
        const vec3 origin(trueNormal * 3.0);
        const auto s = kernel.surfaceAt(origin, vec3(glm::normalize(target - dvec3(origin))), 0.0f, 0.0f, Hit{0, primitive});
        auto shading = kernel.shadingAt(s);
        shading.flags |= MATERIAL_PHONG;  // plain diffuse
        shading.diffuse = vec3(1.0f);
        shading.exponent = 0.0f;
        auto shadow = kernel.lightRay(0, s, shading, -vec3(glm::normalize(target - dvec3(origin))), vec3(1.0f));
        if (!mitigated) shadow.ray.origin = kernel.offsetRayOrigin(s.position, s.geometricNormal, s.clearance);
        const bool dark = blocked(body, dvec3(shadow.ray.origin), dvec3(shadow.ray.direction), shadow.ray.tMax);
        const double exact = cosine * 2500.0 / glm::dot(toLight, toLight);
        const double shown = dark ? 0.0 : EXACT_PI * shadow.contribution.x;
        error += std::abs(shown - exact);
        worst = std::max(worst, std::abs(shown - exact));
        count++;
    }
    EXPECT_GT(count, 3000);
    return {error / count, worst};
}

TEST(Surface, ShadowTerminatorIsNearTheTrueSphere) {
    const TerminatorError fixed = terminatorError(true), plain = terminatorError(false);
    EXPECT_LT(fixed.mean, 5e-4);
    EXPECT_LT(fixed.worst, 2e-3) << "no dark facet is left";
    EXPECT_GT(plain.worst, 0.1) << "rays from the facets themselves: whole facets in the dark";
    EXPECT_GT(plain.mean, 10.0 * fixed.mean);
}

TEST(Surface, ShadowPositionNeverLiesInsideTheBody) {
    const MeshData body = icosphere(1);
    const auto scene = sceneOf(body, mat4(1.0f), false);
    EveryKernel kernel = kernelFor(*scene);
    Random random(2);
    for (int i = 0; i < 20000; i++) {
        const vec3 d = random.direction();
        const uint32_t primitive = random.below(static_cast<uint32_t>(body.indices.size()));
        const uvec3 t = body.indices[primitive];
        const vec3 target = (body.positions[t.x] + body.positions[t.y] * random.real(0.0f, 1.0f) +
                             body.positions[t.z] * random.real(0.0f, 1.0f));
        const vec3 origin = target + d * 5.0f;
        const auto s = kernel.surfaceAt(origin, kernel.normalize3(target - origin), 0.0f, 0.0f, Hit{0, primitive});
        // Seen from outside it rises towards the sphere; from inside it stays on the facet or sinks inwards.
        ASSERT_GE(glm::dot(s.shadowPosition - s.position, s.normal), -1e-6f);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

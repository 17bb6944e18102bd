// Analytic shapes: where rays meet them, what surface is there, and that no ray meets what it leaves. Oracles in double, on the
// floats that the kernel has.

#include "server/scene/build/scene_builder.h"
#include "server/scene/shape.h"
#include "tests/kernel/kernel_access.h"

#include <glm/gtc/matrix_transform.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using glm::dvec3;

constexpr std::array FORMS{ShapeForm{SHAPE_SPHERE}, ShapeForm{SHAPE_CYLINDER, true}, ShapeForm{SHAPE_CYLINDER, false},
                           ShapeForm{SHAPE_DISC}, ShapeForm{SHAPE_PLANE}};

struct Placed {
    std::shared_ptr<const Scene> scene;
    EveryKernel kernel = bareKernel();

    Placed(ShapeForm form, const mat4& toWorld) {
        SceneBuilder builder("shape");
        builder.addInstance(builder.addShape(form, 0), toWorld);
        scene = builder.finish();
        kernel.scene = sceneView(*scene);
        kernel.frame.effects = EFFECT_INSTANCING | EFFECT_TEXTURES;
        kernel.frame.layers = EFFECT_SHAPES >> 32;
    }
    const Instance& instance() const { return scene->instances.at(0); }
    uint32_t kind() const { return shapeKindOf(instance()); }
};

/// Turned, stretched by up to 4 and moved; every other one mirrored.
mat4 somewhere(Random& random, float far) {
    const vec3 size(random.real(0.5f, 2.0f), random.real(0.5f, 2.0f),
                    random.real(0.5f, 2.0f) * (random.below(2) ? -1.0f : 1.0f));
    return glm::translate(mat4(1.0f), random.inCube(far)) *
           glm::rotate(mat4(1.0f), random.real(0.0f, 6.28f), random.direction()) * glm::scale(mat4(1.0f), size);
}

/// A point or vector of the world in the space of the shape, from its middle.
dvec3 inside(const Instance& s, dvec3 v, bool point) {
    if (point) v -= dvec3(s.toWorld0.w, s.toWorld1.w, s.toWorld2.w);
    const auto along = [&](vec4 row) { return glm::dot(dvec3(vec3(row)), v); };
    return {along(s.toObject0), along(s.toObject1) + (point && (s.flags & SHAPE_POLE) ? 1.0 : 0.0), along(s.toObject2)};
}

/// How far a point in its space is off the surface of a shape of that kind.
double offSurface(const Instance& s, dvec3 p) {
    const uint32_t kind = shapeKindOf(s);
    if (kind == SHAPE_SPHERE) return std::abs(glm::length(p) - 1.0);
    if (kind == SHAPE_DISC) return std::max(std::abs(p.y), std::hypot(p.x, p.z) - 1.0);
    if (kind == SHAPE_PLANE) return std::max({std::abs(p.y), std::abs(p.x) - 1.0, std::abs(p.z) - 1.0});
    const double side = std::max(std::abs(std::hypot(p.x, p.z) - 1.0), std::abs(p.y) - 1.0);
    const double cap = std::max(std::abs(std::abs(p.y) - 1.0), std::hypot(p.x, p.z) - 1.0);
    return (s.flags & SHAPE_CAPPED) != 0 ? std::min(side, cap) : side;
}

/// Crossings of the ray with all of the shape's surfaces, ascending, and how clearly a way lies between them.
std::vector<double> crossings(const Instance& s, dvec3 o, dvec3 d, double& margin) {
    std::vector<double> found;
    margin = 1e9;
    const uint32_t kind = shapeKindOf(s);
    const auto level = [&](double y, double limit) {
        const double t = (y - o.y) / d.y;
        const dvec3 p = o + d * t;
        const double r = kind == SHAPE_PLANE ? std::max(std::abs(p.x), std::abs(p.z)) : std::hypot(p.x, p.z);
        margin = std::min(margin, std::abs(r - limit));
        if (r <= limit) found.push_back(t);
    };
    if (kind >= SHAPE_DISC) level(0.0, 1.0);
    if (kind == SHAPE_CYLINDER && (s.flags & SHAPE_CAPPED) != 0) level(1.0, 1.0), level(-1.0, 1.0);
    if (kind <= SHAPE_CYLINDER) {
        dvec3 m = o, way = d;
        if (kind == SHAPE_CYLINDER) m.y = way.y = 0.0;
        const double a = glm::dot(way, way), b = glm::dot(m, way), c = glm::dot(m, m) - 1.0, radicand = b * b - a * c;
        margin = std::min(margin, std::abs(radicand) / a);
        for (double sign : {-1.0, 1.0}) {
            const double t = (-b + sign * std::sqrt(std::max(radicand, 0.0))) / a, y = o.y + d.y * t;
            if (kind == SHAPE_CYLINDER) margin = std::min(margin, std::abs(std::abs(y) - 1.0));
            if (radicand > 0.0 && (kind == SHAPE_SPHERE || std::abs(y) < 1.0)) found.push_back(t);
        }
    }
    std::ranges::sort(found);
    return found;
}

TEST(Shapes, DistancesMatchDoubleWhereverTheyStand) {
    Random random(1);
    uint64_t met = 0;
    for (const ShapeForm form : FORMS) {
        for (int i = 0; i < 300; i++) {
            Placed placed(form, somewhere(random, 6.0f));
            for (int k = 0; k < 60; k++) {
                const vec3 origin = random.inCube(12.0f),
                           target =
                               vec3(placed.instance().toWorld0.w, placed.instance().toWorld1.w, placed.instance().toWorld2.w) +
                               random.inCube(2.0f);
                const vec3 d = placed.kernel.normalize3(target - origin);
                double margin;
                const auto exact = crossings(placed.instance(), inside(placed.instance(), origin, true),
                                             inside(placed.instance(), d, false), margin);
                if (margin < 1e-4) continue;
                const vec2 ends = placed.kernel.shapeDistances(0, origin, d);
                std::vector<double> found;
                for (float t : {ends.x, ends.y})
                    if (t > 0.0f) found.push_back(t);
                std::vector<double> ahead;
                for (double t : exact)
                    if (t > 1e-4) ahead.push_back(t);
                std::erase_if(found, [](double t) { return t < 1e-4; });
                ASSERT_EQ(found.size(), ahead.size()) << shapeName(form.kind) << " " << i << " " << k;
                for (size_t j = 0; j < found.size(); j++) {
                    const dvec3 normal = shapeNormal(placed.instance(), dvec3(origin) + dvec3(d) * ahead[j]);
                    const double cosine = std::abs(glm::dot(normal, dvec3(d)));
                    EXPECT_NEAR(found[j], ahead[j], 2e-5 * (1.0 + ahead[j]) / cosine) << shapeName(form.kind);
                }
                met += found.size();
            }
        }
    }
    EXPECT_GT(met, 20000u);
}

/// Rays that meet a placed shape, with what is there.
template <typename Look>
uint64_t lookAtShapes(uint64_t seed, float far, Look look) {
    Random random(seed);
    uint64_t met = 0;
    for (const ShapeForm form : FORMS) {
        for (int i = 0; i < 200; i++) {
            Placed placed(form, somewhere(random, far));
            const Instance& s = placed.instance();
            for (int k = 0; k < 60; k++) {
                const vec3 origin = vec3(s.toWorld0.w, s.toWorld1.w, s.toWorld2.w) + random.inCube(6.0f);
                const vec3 d = random.direction();
                const vec2 ends = placed.kernel.shapeDistances(0, origin, d);
                for (uint32_t end = 0; end < 2; end++) {
                    if (!((end == 0 ? ends.x : ends.y) > 0.0f)) continue;
                    look(placed, d, placed.kernel.surfaceAt(origin, d, 0.0f, 0.0f, Hit{0, end}), end, random);
                    met++;
                }
            }
        }
    }
    return met;
}

TEST(Shapes, PointsLieOnTheSurfaceAndNormalsAreItsOwn) {
    const uint64_t met =
        lookAtShapes(2, 6.0f, [](Placed& placed, vec3 d, const EveryKernel::Surface& s, uint32_t end, Random&) {
            const Instance& instance = placed.instance();
            const double unit = glm::length(dvec3(vec3(instance.toObject0))) + glm::length(dvec3(vec3(instance.toObject1)));
            EXPECT_LT(offSurface(instance, inside(instance, s.position, true)),
                      4e-7 * (1.0 + glm::length(dvec3(s.position))) * (1.0 + unit))
                << shapeName(placed.kind());
            EXPECT_NEAR(glm::length(s.geometricNormal), 1.0f, 1e-6f);
            EXPECT_EQ(s.normal, s.geometricNormal);
            EXPECT_EQ(s.shadowPosition, s.position);
            // At a cylinder's edge either is right.
            const dvec3 out = shapeNormal(instance, s.position);
            const dvec3 p = inside(instance, s.position, true);
            const bool edge = placed.kind() == SHAPE_CYLINDER && std::abs(std::abs(p.y) - 1.0) < 1e-4 &&
                              std::abs(std::hypot(p.x, p.z) - 1.0) < 1e-4;
            if (!edge) {
                EXPECT_GT(glm::dot(out * double(s.side), dvec3(s.geometricNormal)), 1.0 - 1e-6) << shapeName(placed.kind());
            }
            if (placed.kind() == SHAPE_SPHERE || (instance.flags & SHAPE_CAPPED) != 0) {
                EXPECT_EQ(s.side, end == 0 ? 1.0f : -1.0f);
            }
            EXPECT_LT(glm::dot(s.geometricNormal, d), 2e-3f);
        });
    EXPECT_GT(met, 5000u);
}

// Into the half space that the surface looks at, and through it. A convex body is met again on the way through alone, and an open
// tube by its other side.
TEST(Shapes, NoRayMeetsTheSurfaceItLeaves) {
    for (float far : {2.0f, 1000.0f}) {
        uint64_t back = 0, tried = 0;
        lookAtShapes(3, far, [&](Placed& placed, vec3, const EveryKernel::Surface& s, uint32_t, Random& random) {
            const bool convex = placed.kind() != SHAPE_CYLINDER || (placed.instance().flags & SHAPE_CAPPED) != 0;
            if (!convex) return;
            const vec3 outward = s.geometricNormal * s.side;
            const vec3 start = placed.kernel.offsetRayOrigin(s.position, outward, s.clearance);
            for (int k = 0; k < 8; k++) {
                vec3 d = random.direction();
                if (glm::dot(d, outward) < 0.0f) d = -d;
                if (k == 7) d = placed.kernel.normalize3(d - outward * glm::dot(d, outward) * 0.999f);  // nearly along it
                const vec2 ends = placed.kernel.shapeDistances(0, start, d);
                back += ends.x > 0.0f || ends.y > 0.0f;
                tried++;
            }
        });
        EXPECT_GT(tried, 50000u);
        EXPECT_EQ(back, 0u) << "of " << tried << " at " << far;
    }
}

TEST(Shapes, AClearanceOfAThousandthWouldNotDo) {
    uint64_t back = 0;
    lookAtShapes(4, 1000.0f, [&](Placed& placed, vec3, const EveryKernel::Surface& s, uint32_t, Random& random) {
        if (placed.kind() != SHAPE_SPHERE) return;
        const vec3 outward = s.geometricNormal * s.side;
        vec3 d = random.direction();
        if (glm::dot(d, outward) < 0.0f) d = -d;
        const vec2 ends = placed.kernel.shapeDistances(0, s.position + outward * (s.clearance * 0.001f), d);
        back += ends.x > 0.0f || ends.y > 0.0f;
    });
    EXPECT_GT(back, 0u);
}

TEST(Shapes, TextureRunsRoundABallFromItsTopDown) {
    Placed placed({SHAPE_SPHERE}, glm::translate(mat4(1.0f), vec3(5, 5, 5)));
    const auto uvOf = [&](vec3 from) {
        return placed.kernel.surfaceAt(vec3(5.0f) + from * 3.0f, -from, 0.0f, 0.0f, Hit{0, 0}).uv0;
    };
    EXPECT_NEAR(uvOf({0, 0, 1}).x, 0.5f, 1e-6f);
    EXPECT_NEAR(uvOf({1, 0, 0}).x, 0.75f, 1e-6f);
    EXPECT_NEAR(uvOf({0, 1, 0}).y, 0.0f, 1e-3f);
    EXPECT_NEAR(uvOf({0, 0, 1}).y, 0.5f, 1e-6f);
    EXPECT_NEAR(uvOf({0, -1, 0}).y, 1.0f, 1e-3f);
}

// Where a ball's space begins decides nothing but its digits: a texture stays where it is.
TEST(Shapes, ABallByItsRimHasTheSameTexture) {
    const mat4 turned = glm::rotate(mat4(1.0f), 0.7f, glm::normalize(vec3(1, 2, 3)));
    Placed away({SHAPE_SPHERE}, glm::translate(mat4(1.0f), vec3(40, 0, 0)) * turned);
    Placed near({SHAPE_SPHERE}, glm::translate(mat4(1.0f), vec3(0.6f, -0.8f, 0.02f)) * turned);
    ASSERT_EQ(away.instance().flags & SHAPE_POLE, 0u);
    ASSERT_EQ(near.instance().flags & SHAPE_POLE, SHAPE_POLE);
    Random random(9);
    for (int i = 0; i < 200; i++) {
        const vec3 d = random.direction();
        const auto a = away.kernel.surfaceAt(vec3(40, 0, 0) - d * 4.0f, d, 0.0f, 0.0f, Hit{0, 0});
        const auto b = near.kernel.surfaceAt(vec3(0.6f, -0.8f, 0.02f) - d * 4.0f, d, 0.0f, 0.0f, Hit{0, 0});
        if (a.uv0.y < 0.02f || a.uv0.y > 0.98f || a.uv0.x < 0.01f || a.uv0.x > 0.99f) continue;
        EXPECT_NEAR(a.uv0.x, b.uv0.x, 2e-4f);
        EXPECT_NEAR(a.uv0.y, b.uv0.y, 2e-4f);
    }
}

TEST(Shapes, APlanesTextureIsInMetresOfItsNode) {
    Placed placed({SHAPE_PLANE}, glm::translate(mat4(1.0f), vec3(3, 1, -2)) * glm::scale(mat4(1.0f), vec3(2.0f)));
    const auto s = placed.kernel.surfaceAt(vec3(8, 5, 4), vec3(0, -1, 0), 0.0f, 0.0f, Hit{0, 0});
    EXPECT_NEAR(s.uv0.x, 2.5f, 1e-4f);
    EXPECT_NEAR(s.uv0.y, 3.0f, 1e-4f);
    EXPECT_EQ(s.position.y, 1.0f);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

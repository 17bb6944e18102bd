// Cases 4, 6 and 7: rays and balls. The kernel has one such test, for the ball of fog (fogSpan); spheres as primitives are
// still to come.

#include "tests/hard/cases.h"
#include "tests/hard/exact.h"
#include "tests/hard/tracer.h"

namespace heliograph::hard {

namespace {

using test::Random;

/// Begin of the way in the ball, and its length; length 0 where the ray passes.
struct Span {
    float begin, way;
};

Span kernelSpan(test::EveryKernel& kernel, vec3 origin, vec3 direction, vec3 center, float radius) {
    kernel.frame.fogCenter = center;
    kernel.frame.fogRadius = radius;
    const vec2 span = kernel.fogSpan(origin, direction, test::EveryKernel::FLOAT_MAX);
    return {span.x, span.y};
}

/// The quadratic formula as books have it, and the nearest root beyond the fixed epsilon.
Span naiveSpan(vec3 origin, vec3 direction, vec3 center, float radius) {
    const vec3 o = origin - center;
    const float a = glm::dot(direction, direction), b = 2.0f * glm::dot(o, direction), c = glm::dot(o, o) - radius * radius;
    const float discriminant = b * b - 4.0f * a * c;
    if (discriminant < 0.0f) return {0.0f, 0.0f};
    const float root = std::sqrt(discriminant), near = (-b - root) / (2.0f * a), far = (-b + root) / (2.0f * a);
    if (near > 0.01f) return {near, far - near};
    return {0.0f, far > 0.01f ? far : 0.0f};
}

Span spanOf(const char* column, test::EveryKernel& kernel, vec3 origin, vec3 direction, vec3 center, float radius) {
    if (column == column::NAIVE) return naiveSpan(origin, direction, center, radius);
    return kernelSpan(kernel, origin, direction, center, radius);
}

constexpr const char* BOTH[] = {column::NAIVE, column::OWN};

}  // namespace

void farSpheres(Run& run) {
    test::EveryKernel kernel = test::bareKernel();
    for (const char* column : BOTH) {
        Random random(4);
        for (float far : {1e2f, 1e3f, 1e4f}) {
            const uint64_t n = run.count(20000, 2000000);
            for (uint64_t i = 0; i < n; i++) {
                const vec3 toCenter = random.direction(), center = toCenter * far;
                vec3 u, v;
                kernel.orthonormalBasis(toCenter, u, v);
                const double r = std::sqrt(random.number(0.0, 1.0)), turn = random.number(0.0, 2.0 * test::EXACT_PI);
                const vec3 target = center + u * float(r * std::cos(turn)) + v * float(r * std::sin(turn));
                const vec3 d = kernel.normalize3(target);
                const BallRoots exact = meetBall(vec3(0.0f), d, center, 1.0f);
                if (!exact.meets) continue;
                const Span span = spanOf(column, kernel, vec3(0.0f), d, center, 1.0f);
                const double error = static_cast<double>(absolute(Quad(span.begin) - exact.near));
                const double allowed = 4.0 * ulpOf(float(double(exact.near))) + 1e-6;
                run.most(column, "|dt| / (4 ulp + 1e-6 r)", span.way > 0.0f ? error / allowed : 0.0, 1.0, 1,
                         replayOf("far_spheres", makeRay(vec3(0.0f), d)));
                // Whoever grazes the rim within what float holds of the distance may pass.
                const bool clear = double(exact.far - exact.near) > 2.0 * std::sqrt(ulpOf(far) * 4.0);
                run.rate(column, "missed", clear && !(span.way > 0.0f), clear, 0.0,
                         replayOf("far_spheres", makeRay(vec3(0.0f), d)));
            }
        }
    }
}

void tangentSpheres(Run& run) {
    test::EveryKernel kernel = test::bareKernel();
    for (const char* column : BOTH) {
        Random random(6);
        for (uint64_t i = 0; i < run.count(200000, 20000000); i++) {
            const int k = int(i % 17) - 8, axis = int(i % 3);
            const double turn = random.number(0.0, 2.0 * test::EXACT_PI), impact = 1.0 + k * 0x1p-23;
            vec3 origin(0.0f), d(0.0f);
            origin[axis] = -random.real(2.0f, 8.0f);
            origin[(axis + 1) % 3] = float(impact * std::cos(turn));
            origin[(axis + 2) % 3] = float(impact * std::sin(turn));
            d[axis] = 1.0f;
            const BallRoots exact = meetBall(origin, d, vec3(0.0f), 1.0f);
            QuadVector foot(origin);
            (axis == 0 ? foot.x : axis == 1 ? foot.y : foot.z) = 0;
            const double offBy = static_cast<double>((length(foot) - 1) * 0x1p23);
            const Span span = spanOf(column, kernel, origin, d, vec3(0.0f), 1.0f);
            const std::string replay = replayOf("tangent_spheres", makeRay(origin, d));
            run.rate(column, "not a number", !(std::isfinite(span.begin) && std::isfinite(span.way)), 1, 0.0, replay);
            const bool clear = std::fabs(offBy) > 2.0;
            run.rate(column, "hit for miss beyond 2 ulp", clear && exact.meets != (span.way > 0.0f), clear, 0.0, replay);
        }
    }
}

void insideSpheres(Run& run) {
    test::EveryKernel kernel = test::bareKernel();
    for (const char* column : BOTH) {
        Random random(7);
        for (uint64_t i = 0; i < run.count(300000, 10000000); i++) {
            vec3 origin(0.0f);
            const auto where = i % 4;  // the centre; on the surface; an ulp inside; an ulp outside
            if (where > 0) origin = random.direction();
            if (where == 2) origin *= 1.0f - 0x1p-23f;
            if (where == 3) origin *= 1.0f + 0x1p-23f;
            vec3 d = random.direction();
            const BallRoots exact = meetBall(origin, d, vec3(0.0f), 1.0f);
            const Quad begin = exact.near > 0 ? exact.near : Quad(0);
            const Quad way = exact.meets && exact.far > begin ? exact.far - begin : Quad(0);
            const Span span = spanOf(column, kernel, origin, d, vec3(0.0f), 1.0f);
            const std::string replay = replayOf("inside_spheres", makeRay(origin, d));
            const double error = std::fabs(double(span.begin + span.way) - double(way > 0 ? exact.far : 0));
            if (where == 0) run.most(column, "error from the centre / ulp", error / 0x1p-23, 4.0, 1, replay);
            else {
                // An ulp of the start moves the end by as much over the cosine at the surface, which is half the chord.
                const double half = 0.5 * std::fabs(double(exact.far - exact.near));
                const bool looked = way > Quad(1e-3) || span.way > 1e-3f;
                run.most(column, "error of the end / (ulp / cosine)", looked ? error * half / 0x1p-23 : 0.0, 4.0, 1, replay);
            }
            const bool leaves = where > 0 && glm::dot(origin, d) > 1e-3f;
            run.rate(column, "met again on the way out", leaves && span.way > 1e-3f, leaves, 0.0, replay);
        }
    }
}

}  // namespace heliograph::hard

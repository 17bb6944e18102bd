// Cases 4 to 7: rays and balls. The kernel has two such tests: for the ball of fog (fogSpan, column own) and for spheres as
// primitives (effects/shapes.glsl), which all of the product's tracers ask.

#include "tests/hard/cases.h"
#include "tests/hard/exact.h"
#include "tests/hard/tracer.h"

#include <glm/gtc/matrix_transform.hpp>

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

World ballOf(vec3 center, float radius) {
    return {{SHAPE_SPHERE}, glm::translate(mat4(1.0f), center) * glm::scale(mat4(1.0f), vec3(radius))};
}

/// What each of the product's tracers meets of a ball, judged ray by ray.
void onDevices(Run& run, const World& world, const std::vector<Ray>& rays,
               const std::function<void(const Tracer&, const Ray&, const Met&)>& judge) {
    for (const auto& tracer : ownTracersOf(world, run)) {
        std::vector<Met> met;
        tracer->trace(rays, met);
        for (size_t i = 0; i < rays.size(); i++) judge(*tracer, rays[i], met[i]);
    }
}

/// A ray from the origin to the disc that a unit ball shows from there.
Ray towards(test::EveryKernel& kernel, Random& random, vec3 toCenter, float far) {
    vec3 u, v;
    kernel.orthonormalBasis(toCenter, u, v);
    const double r = std::sqrt(random.number(0.0, 1.0)), turn = random.number(0.0, 2.0 * test::EXACT_PI);
    return makeRay(vec3(0.0f),
                   kernel.normalize3(toCenter * far + u * float(r * std::cos(turn)) + v * float(r * std::sin(turn))));
}

void farOnDevices(Run& run, test::EveryKernel& kernel, float far) {
    Random random(44);
    for (int place = 0; place < 4; place++) {
        const vec3 toCenter = random.direction(), center = toCenter * far;
        std::vector<Ray> rays;
        for (uint64_t i = 0; i < run.count(5000, 500000); i++) rays.push_back(towards(kernel, random, toCenter, far));
        onDevices(run, ballOf(center, 1.0f), rays, [&](const Tracer& tracer, const Ray& ray, const Met& met) {
            const BallRoots exact = meetBall(ray.origin, ray.direction, center, 1.0f);
            const bool clear = exact.meets && double(exact.far - exact.near) > 2.0 * std::sqrt(ulpOf(far) * 4.0);
            const std::string replay = replayOf("far_spheres", ray);
            run.rate(tracer.column(), "sphere: missed", clear && !met.hit(), clear, 0.0, replay);
            if (!exact.meets || !met.hit()) return;
            const double allowed = 4.0 * ulpOf(float(double(exact.near))) + 1e-6;
            run.most(tracer.column(), "sphere: |dt| / (4 ulp + 1e-6 r)", double(absolute(Quad(met.t) - exact.near)) / allowed,
                     1.0, 1, replay);
        });
    }
}

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
    for (float far : {1e2f, 1e3f, 1e4f}) farOnDevices(run, kernel, far);
}

namespace {

constexpr float GROUND = 1e6f;          // radius of case 5
const vec3 UNDER(0.0f, -GROUND, 0.0f);  // its middle

double offGround(const QuadVector& point) {
    return std::fabs(static_cast<double>(length(point - QuadVector(UNDER)) - Quad(GROUND)));
}

/// How `t` fits the ground that a ray from 2 m over it looks at. A step of a point by a ulp of its coordinates moves the end of the
/// way by as much over the cosine.
void judgeGround(Run& run, const char* column, const Ray& ray, bool hit, float t, const QuadVector& point) {
    const BallRoots exact = meetBall(ray.origin, ray.direction, UNDER, GROUND);
    const std::string replay = replayOf("huge_sphere", ray);
    const bool clear = exact.meets && exact.near > 0;
    run.rate(column, "missed", clear && !hit, clear, 0.0, replay);
    if (!clear || !hit) return;
    const double near = static_cast<double>(exact.near), cosine = 0.5 * static_cast<double>(exact.far - exact.near) / GROUND;
    run.most(column, "distance from the surface / m", offGround(point), 1e-3, 1, replay);
    run.most(column, "|dt| / (4 ulp / cosine)", std::fabs(t - near) * cosine / (4.0 * ulpOf(float(near))), 1.0, 1, replay);
}

/// A scanline from under the eye to the horizon, which is at sqrt(4 / GROUND) = 0.002 radians: ever farther.
std::vector<Ray> scanline(uint64_t count, double turn) {
    std::vector<Ray> rays;
    for (uint64_t i = 0; i < count; i++) {
        const double down = 1.5 * std::pow(0.0025 / 1.5, double(i) / double(count)), level = std::cos(down);
        rays.push_back(
            makeRay({0, 2, 0}, {float(level * std::cos(turn)), float(-std::sin(down)), float(level * std::sin(turn))}));
    }
    return rays;
}

void groundOnDevices(Run& run) {
    const World world = ballOf(UNDER, GROUND);
    Random random(5);
    for (int line = 0; line < 8; line++) {
        const std::vector<Ray> rays = scanline(run.count(20000, 1000000), random.number(0.0, 2.0 * test::EXACT_PI));
        for (const auto& tracer : ownTracersOf(world, run)) {
            std::vector<Met> met, again;
            tracer->trace(rays, met);
            std::vector<Ray> leaving;
            for (size_t i = 0; i < rays.size(); i++) {
                judgeGround(run, tracer->column(), rays[i], met[i].hit(), met[i].t,
                            met[i].hit() ? tracer->point(rays[i], met[i]) : vec3(0.0f));
                const bool back = i > 0 && met[i].hit() && met[i - 1].hit() && met[i].t < met[i - 1].t;
                run.rate(tracer->column(), "nearer than the ray before", back, 1, 0.0, replayOf("huge_sphere", rays[i]));
                if (!met[i].hit()) continue;
                vec3 out = random.direction();
                const vec3 up = glm::normalize(tracer->point(rays[i], met[i]) - UNDER);
                if (glm::dot(out, up) < 0.0f) out -= up * (2.0f * glm::dot(out, up));
                leaving.push_back(tracer->leave(rays[i], met[i], out));
            }
            tracer->trace(leaving, again);
            for (size_t i = 0; i < leaving.size(); i++) {
                // One that dips below the horizon may.
                const BallRoots exact = meetBall(leaving[i].origin, leaving[i].direction, UNDER, GROUND);
                const bool met_ = again[i].hit() && !(exact.meets && exact.near > 0);
                run.rate(tracer->column(), "met again on the way out", met_, 1, 0.0, replayOf("huge_sphere", leaving[i]));
            }
        }
    }
}

}  // namespace

void hugeSphere(Run& run) {
    for (const Ray& ray : scanline(20000, 0.3)) {
        const Span span = naiveSpan(ray.origin, ray.direction, UNDER, GROUND);
        judgeGround(run, column::NAIVE, ray, span.way > 0.0f, span.begin,
                    QuadVector(ray.origin) + QuadVector(ray.direction) * span.begin);
    }
    groundOnDevices(run);
}

namespace {

/// Past a unit ball about 0, at k ulps from its rim.
Ray grazing(Random& random, int k, int axis) {
    const double turn = random.number(0.0, 2.0 * test::EXACT_PI), impact = 1.0 + k * 0x1p-23;
    vec3 origin(0.0f), d(0.0f);
    origin[axis] = -random.real(2.0f, 8.0f);
    origin[(axis + 1) % 3] = float(impact * std::cos(turn));
    origin[(axis + 2) % 3] = float(impact * std::sin(turn));
    d[axis] = 1.0f;
    return makeRay(origin, d);
}

/// How many ulps it really is off the rim.
double offRim(const Ray& ray) {
    QuadVector foot(ray.origin);
    (ray.direction.x > 0.0f ? foot.x : ray.direction.y > 0.0f ? foot.y : foot.z) = 0;
    return static_cast<double>((length(foot) - 1) * 0x1p23);
}

void tangentOnDevices(Run& run) {
    Random random(66);
    std::vector<Ray> rays;
    for (uint64_t i = 0; i < run.count(100000, 5000000); i++) rays.push_back(grazing(random, int(i % 17) - 8, int(i % 3)));
    onDevices(run, ballOf(vec3(0.0f), 1.0f), rays, [&](const Tracer& tracer, const Ray& ray, const Met& met) {
        const std::string replay = replayOf("tangent_spheres", ray);
        const bool clear = std::fabs(offRim(ray)) > 2.0;
        run.rate(tracer.column(), "sphere: not a number", met.hit() && !std::isfinite(met.t), 1, 0.0, replay);
        run.rate(tracer.column(), "sphere: hit for miss beyond 2 ulp",
                 clear && meetBall(ray.origin, ray.direction, vec3(0.0f), 1.0f).meets != met.hit(), clear, 0.0, replay);
    });
}

/// From the centre, from the surface and an ulp inside and outside.
void insideOnDevices(Run& run) {
    Random random(77);
    std::vector<Ray> rays;
    for (uint64_t i = 0; i < run.count(100000, 5000000); i++) {
        vec3 origin = i % 4 > 0 ? random.direction() : vec3(0.0f);
        if (i % 4 > 1) origin *= i % 4 == 2 ? 1.0f - 0x1p-23f : 1.0f + 0x1p-23f;
        rays.push_back(makeRay(origin, random.direction()));
    }
    onDevices(run, ballOf(vec3(0.0f), 1.0f), rays, [&](const Tracer& tracer, const Ray& ray, const Met& met) {
        const BallRoots exact = meetBall(ray.origin, ray.direction, vec3(0.0f), 1.0f);
        const std::string replay = replayOf("inside_spheres", ray);
        const bool leaves = ray.origin != vec3(0.0f) && glm::dot(ray.origin, ray.direction) > 1e-3f;
        run.rate(tracer.column(), "sphere: met again on the way out", leaves && met.hit() && met.t > 1e-3f, leaves, 0.0,
                 replay);
        if (!met.hit() || met.t <= 1e-3f) return;
        const double half = 0.5 * std::fabs(double(exact.far - exact.near));
        run.most(tracer.column(), "sphere: error of the end / (ulp / cosine)",
                 std::fabs(double(Quad(met.t) - exact.far)) * half / 0x1p-23, 4.0, 1, replay);
    });
}

}  // namespace

void tangentSpheres(Run& run) {
    test::EveryKernel kernel = test::bareKernel();
    tangentOnDevices(run);
    for (const char* column : BOTH) {
        Random random(6);
        for (uint64_t i = 0; i < run.count(200000, 20000000); i++) {
            const Ray ray = grazing(random, int(i % 17) - 8, int(i % 3));
            const vec3 origin = ray.origin, d = ray.direction;
            const BallRoots exact = meetBall(origin, d, vec3(0.0f), 1.0f);
            const double offBy = offRim(ray);
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
    insideOnDevices(run);
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

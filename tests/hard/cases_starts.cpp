// Cases 12, 13 and 15: where rays meet large surfaces, and where the next ones start.

#include "tests/hard/cases.h"
#include "tests/hard/exact.h"
#include "tests/hard/tracer.h"
#include "tests/support/bodies.h"

#include <glm/gtc/matrix_transform.hpp>

namespace heliograph::hard {

namespace {

using glm::dvec3;
using test::Random;

double relative(Quad value, Quad exact) { return static_cast<double>(absolute(value - exact) / absolute(exact)); }

/// Of the rays that go on from what was met into the open: how many meet the mesh. One for each ray, as `towards` says.
template <typename Towards>
void countSelfHits(Run& run, Tracer& tracer, std::span<const Ray> rays, std::span<const Met> met, const char* name,
                   Towards towards) {
    std::vector<Ray> next;
    for (size_t i = 0; i < rays.size(); i++)
        if (met[i].hit()) next.push_back(tracer.leave(rays[i], met[i], towards(rays[i])));
    std::vector<Met> again;
    tracer.trace(next, again);
    uint64_t count = 0;
    size_t first = 0;
    for (size_t i = 0; i < next.size(); i++)
        if (again[i].hit() && count++ == 0) first = i;
    run.rate(tracer.column(), "self-hits", count, next.size(), 0.0, next.empty() ? "" : replayOf(name, next[first]));
}

}  // namespace

void grazing(Run& run) {
    const World world(test::panel(vec3(-5000, 0, 5000), vec3(10000, 0, 0), vec3(0, 0, -10000)));
    const double angles[] = {89.9, 89.99, 89.999, 89.9999};
    for (const auto& tracer : tracersOf(world, run)) {
        Random random(12);
        std::vector<Ray> rays;
        for (uint64_t i = 0; i < run.count(400000, 20000000); i++) {
            const double angle = angles[i % 4] * test::EXACT_PI / 180.0, turn = random.number(0.0, 2.0 * test::EXACT_PI);
            const double reach = 4000.0 * std::cos(angle);  // so that the hit lies on the quad
            const auto height = static_cast<float>(std::min(random.magnitude(1e-6, 1.0), reach));
            const dvec3 d(std::sin(angle) * std::cos(turn), -std::cos(angle), std::sin(angle) * std::sin(turn));
            rays.push_back(makeRay(vec3(0.0f, height, 0.0f), vec3(d)));
        }
        std::vector<Met> met;
        tracer->trace(rays, met);
        uint64_t missed = 0;
        for (size_t i = 0; i < rays.size(); i++) {
            missed += !met[i].hit();
            if (!met[i].hit()) continue;
            const Quad exact = -Quad(rays[i].origin.y) / Quad(rays[i].direction.y);
            run.most(tracer->column(), "|dt| / t", relative(met[i].t, exact), 1e-4, 1, replayOf("grazing", rays[i]));
        }
        run.rate(tracer->column(), "missed", missed, rays.size(), 0.0);
        countSelfHits(run, *tracer, rays, met, "grazing", [](const Ray& r) { return r.direction * vec3(1, -1, 1); });
    }
}

void hugeTriangle(Run& run) {
    Random shapes(13);
    for (int shape = 0; shape < 4; shape++) {
        const mat3 turn(glm::rotate(mat4(1.0f), shapes.real(0.3f, 1.2f), shapes.direction()));
        MeshData mesh;
        for (vec3 p : {vec3(-1e7f, 0, -1e7f), vec3(1e7f, 0, -1e7f), vec3(0, 0, 1e7f)}) mesh.positions.push_back(turn * p);
        mesh.indices = {{0, 2, 1}};
        mesh.materials = {0};
        const World world(mesh);
        const vec3 a = mesh.positions[0], b = mesh.positions[1], c = mesh.positions[2];
        const QuadVector exactNormal = cross(QuadVector(c) - QuadVector(a), QuadVector(b) - QuadVector(a));
        const vec3 normal = glm::normalize(turn * vec3(0, 1, 0));
        for (const auto& tracer : tracersOf(world, run)) {
            Random random(130 + shape);
            std::vector<Ray> rays;
            for (uint64_t i = 0; i < run.count(250000, 10000000); i++) {
                const vec3 aim = turn * vec3(random.real(-1, 1), 0, random.real(-1, 1));
                vec3 from = random.direction();
                if (glm::dot(from, normal) < 0.0f) from = -from;
                if (glm::dot(from, normal) < 0.1f) from = normal;
                rays.push_back(makeRay(aim + from * random.real(1.5f, 3.0f), -from));
            }
            std::vector<Met> met;
            tracer->trace(rays, met);
            for (size_t i = 0; i < rays.size(); i++) {
                if (!met[i].hit()) continue;
                const vec3 p = tracer->point(rays[i], met[i]);
                const Quad off = dot(QuadVector(p) - QuadVector(a), exactNormal) / length(exactNormal);
                run.most(tracer->column(), "distance from the plane / ulp of 1e7", double(absolute(off)), 4.0, 1,
                         replayOf("huge_triangle", rays[i]));
            }
            countSelfHits(run, *tracer, rays, met, "huge_triangle", [&](const Ray&) {
                vec3 d = random.direction();
                if (glm::dot(d, normal) < 0.0f) d = -d;
                return glm::dot(d, normal) < 0.01f ? normal : d;
            });
        }
    }
}

namespace {

constexpr uint32_t UNDERSIDE = 2 + 8;  // first triangle of the cube's face towards the plane (test::box)

/// A unit cube over a plane of side 2 `half` by a gap of `h`, turned as a whole. Triangles 0 and 1 are the plane.
struct Gap {
    mat3 turn;
    float h;
    MeshData mesh;

    Gap(const mat3& t, float half, float gap) : turn(t), h(gap) {
        mesh = test::panel(vec3(-half, 0, half), vec3(2 * half, 0, 0), vec3(0, 0, -2 * half));
        const MeshData cube = test::box(vec3(-0.5f, h, -0.5f), vec3(0.5f, 1.0f + h, 0.5f));
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), cube.positions.begin(), cube.positions.end());
        for (uvec3 i : cube.indices) mesh.indices.push_back(i + first);
        mesh.materials.assign(mesh.indices.size(), 0u);
        mesh.normals.clear();
        mesh.uv0.clear();
        for (vec3& p : mesh.positions) p = vec3(glm::dmat3(turn) * dvec3(p));
    }
};

}  // namespace

namespace {

/// Rays that leave the plane below the cube's middle, each within reach of its underside; every tracer from its own start.
std::vector<Ray> fromBelow(const Gap& gap, const Tracer& tracer, Random& random, uint64_t count) {
    std::vector<Ray> rays;
    const std::vector<vec3>& p = gap.mesh.positions;
    for (uint64_t i = 0; i < count; i++) {
        const vec3 foot(random.real(-0.3f, 0.3f), 0, random.real(-0.3f, 0.3f));
        const Ray down = makeRay(gap.turn * (foot + vec3(0, gap.h * 0.5f, 0)), gap.turn * vec3(0, -1, 0));
        Met m;
        m.triangle = insideBy(down.origin, down.direction, p[0], p[1], p[2]) >= 0.0 ? 0u : 1u;
        const uvec3 t = gap.mesh.indices[m.triangle];
        m.t = float(double(meetPlane(down.origin, down.direction, p[t.x], p[t.y], p[t.z])));
        vec3 d = random.direction();
        const float across = std::sqrt(d.x * d.x + d.z * d.z);
        d.y = std::max({std::fabs(d.y), gap.h / 0.15f * across, 1e-3f});  // at the underside within 0.15 of the foot
        rays.push_back(tracer.leave(down, m, glm::normalize(gap.turn * d)));
    }
    return rays;
}

void countContacts(Run& run, Tracer& tracer, std::span<const Ray> rays) {
    std::vector<Met> met;
    tracer.trace(rays, met);
    uint64_t self = 0, missed = 0;
    size_t firstSelf = 0, firstMissed = 0;
    for (size_t i = 0; i < rays.size(); i++) {
        if (met[i].triangle < 2 && self++ == 0) firstSelf = i;
        if (met[i].triangle != UNDERSIDE && met[i].triangle != UNDERSIDE + 1 && missed++ == 0) firstMissed = i;
    }
    run.rate(tracer.column(), "self-hits", self, rays.size(), 1e-6, replayOf("contact", rays[firstSelf]));
    run.rate(tracer.column(), "missed contact, gaps from 64 ulp of the largest corner", missed, rays.size(), 1e-3,
             replayOf("contact", rays[firstMissed]));
}

}  // namespace

void contact(Run& run) {
    Random turns(15);
    for (auto [half, least] : {std::pair{1.0f, -17}, std::pair{4.0f, -15}}) {
        for (int exponent = least; exponent <= 0; exponent++) {
            const mat3 turn(glm::rotate(mat4(1.0f), turns.real(0.2f, 1.3f), turns.direction()));
            const Gap gap(turn, half, std::ldexp(1.0f, exponent));
            const World world(gap.mesh);
            for (const auto& tracer : tracersOf(world, run)) {
                Random random(150 + exponent);
                countContacts(run, *tracer, fromBelow(gap, *tracer, random, run.count(30000, 1000000)));
            }
        }
    }
}

}  // namespace heliograph::hard

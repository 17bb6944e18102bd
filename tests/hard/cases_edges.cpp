// Cases 8, 9 and 10: closed bodies without holes, at random and where rays are aimed at edges and vertices.

#include "tests/hard/cases.h"
#include "tests/hard/exact.h"
#include "tests/hard/tracer.h"
#include "tests/support/bodies.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace heliograph::hard {

namespace {

using test::Random;

constexpr vec3 SQUASH(1.0f, 1e-3f, 7.0f);
constexpr size_t AT_ONCE = 1u << 20;

MeshData squashedSphere(int subdivisions) {
    MeshData mesh = test::icosphere(subdivisions);
    for (vec3& p : mesh.positions) p = p * SQUASH;
    return mesh;
}

MeshData turned(MeshData mesh, Random& random) {
    const mat3 turn(glm::rotate(mat4(1.0f), random.real(0.0f, 6.28f), random.direction()));
    for (vec3& p : mesh.positions) p = turn * p;
    return mesh;
}

/// The same aim with a length that every device takes, |x| + |y| + |z| <= 2: a power of two rounds nothing.
vec3 aimed(vec3 d) {
    const float longest = std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
    int exponent = 0;
    std::frexp(longest, &exponent);
    return d * std::ldexp(1.0f, -exponent - 1);
}

void countLeaks(Run& run, Tracer& tracer, std::span<const Ray> rays, const char* name, const char* metric) {
    std::vector<Met> met;
    tracer.trace(rays, met);
    uint64_t leaks = 0;
    size_t first = 0;
    for (size_t i = 0; i < rays.size(); i++) {
        if (met[i].hit()) continue;
        if (leaks++ == 0) first = i;
    }
    run.rate(tracer.column(), metric, leaks, rays.size(), 0.0, replayOf(name, rays[first]));
}

/// Rays from the middle to every vertex and through every edge's midpoint, as floats have it.
struct Aims {
    std::vector<Ray> vertices, edges;

    explicit Aims(const MeshData& mesh, vec3 origin = vec3(0.0f)) {
        for (vec3 p : mesh.positions) vertices.push_back(makeRay(origin, aimed(p - origin)));
        for (uvec3 t : mesh.indices)
            for (int k = 0; k < 3; k++)
                edges.push_back(
                    makeRay(origin, aimed((mesh.positions[t[k]] + mesh.positions[t[(k + 1) % 3]]) * 0.5f - origin)));
    }
};

}  // namespace

void watertightEdges(Run& run) {
    const World world(squashedSphere(5));
    const auto tracers = tracersOf(world, run);
    const Aims aims(world.mesh());
    for (const auto& tracer : tracers) {
        countLeaks(run, *tracer, aims.edges, "watertight_edges", "leaks at midpoints of edges");
        Random random(8);
        for (uint64_t left = run.count(1u << 21, 400u << 20); left > 0;) {
            std::vector<Ray> rays(std::min<uint64_t>(left, AT_ONCE));
            for (Ray& ray : rays) {
                // Well within the body, whose facets lie up to a 1000th inside of the sphere.
                const vec3 origin = random.direction() * float(0.9 * std::cbrt(random.number(0.0, 1.0))) * SQUASH;
                ray = makeRay(origin, aimed(random.direction()));
            }
            countLeaks(run, *tracer, rays, "watertight_edges", "leaks of random rays");
            left -= rays.size();
        }
    }
}

void vertexHits(Run& run) {
    Random random(9);
    run.known(column::EMBREE, "leaks at vertices", 0.05,
              "Embree's robust mode decides edges one by one; RenderKit/embree 181 and 188 are open");
    for (int turn = 0; turn < 6; turn++) {
        const World world(turned(turn % 2 == 0 ? test::icosphere(5) : squashedSphere(5), random));
        const Aims aims(world.mesh());
        for (const auto& tracer : tracersOf(world, run)) {
            countLeaks(run, *tracer, aims.vertices, "vertex_hits", "leaks at vertices");
        }
    }
}

namespace {

/// Crossings of a closed body: hits at one distance (2 ulp) whose triangles face the same way are one.
int crossings(const MeshData& mesh, const Ray& ray, std::vector<Met> met) {
    std::sort(met.begin(), met.end(), [](const Met& a, const Met& b) { return a.t < b.t; });
    const auto faces = [&](const Met& m) {
        const uvec3 t = mesh.indices[m.triangle];
        const vec3 a = mesh.positions[t.x];
        return dot(QuadVector(ray.direction),
                   cross(QuadVector(mesh.positions[t.y]) - QuadVector(a), QuadVector(mesh.positions[t.z]) - QuadVector(a))) > 0;
    };
    int count = 0;
    for (size_t i = 0; i < met.size(); i++) {
        bool again = false;
        for (size_t j = i; j-- > 0 && met[i].t - met[j].t <= 2.0 * ulpOf(met[i].t);)
            again = again || faces(met[i]) == faces(met[j]);
        count += !again;
    }
    return count;
}

void countParity(Run& run, Tracer& tracer, const MeshData& mesh, std::span<const Ray> rays, const char* metric, double bound) {
    std::vector<std::vector<Met>> met;
    if (!tracer.traceAll(rays, met)) return;
    uint64_t even = 0;
    size_t first = 0;
    for (size_t i = 0; i < rays.size(); i++) {
        if (crossings(mesh, rays[i], std::move(met[i])) % 2 == 1) continue;
        if (even++ == 0) first = i;
    }
    run.rate(tracer.column(), metric, even, rays.size(), bound, replayOf("double_hits", rays[first]));
}

}  // namespace

void doubleHits(Run& run) {
    const World world(test::icosphere(5));
    const Aims aims(world.mesh());
    run.known(column::OWN, "even parity at midpoints of edges", 1e-3,
              "both neighbours of an edge report it, with distances that differ by more than the 2 ulp of the merge");
    for (const auto& tracer : tracersOf(world, run)) {
        Random random(10);
        for (uint64_t left = run.count(1u << 20, 64u << 20); left > 0;) {
            std::vector<Ray> rays(std::min<uint64_t>(left, AT_ONCE));
            for (Ray& ray : rays) ray = makeRay(random.direction() * random.real(0.0f, 0.9f), aimed(random.direction()));
            countParity(run, *tracer, world.mesh(), rays, "even parity of random rays", 1e-6);
            left -= rays.size();
        }
        countParity(run, *tracer, world.mesh(), aims.edges, "even parity at midpoints of edges", 0.0);
    }
}

}  // namespace heliograph::hard

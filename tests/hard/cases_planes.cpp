// Cases 14, 16 and 17: surfaces in one place, rays along the axes, and numbers at the ends of float.

#include "tests/hard/cases.h"
#include "tests/hard/exact.h"
#include "tests/hard/tracer.h"
#include "tests/support/bodies.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>

namespace heliograph::hard {

namespace {

using test::Random;

void joinPlain(MeshData& mesh, const MeshData& other) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (uvec3 t : other.indices) mesh.indices.push_back(t + first);
    mesh.materials.assign(mesh.indices.size(), 0u);
    mesh.normals.clear();
    mesh.uv0.clear();
}

/// Two squares of side 2 in one plane, turned; the second is cut along its other diagonal if `otherwise`.
MeshData twoInOne(const mat3& turn, bool otherwise) {
    MeshData mesh = test::panel(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0));
    MeshData second = mesh;
    if (otherwise) second.indices = {{0, 1, 3}, {1, 2, 3}};
    joinPlain(mesh, second);
    for (vec3& p : mesh.positions) p = turn * p + vec3(0.3f, 0.2f, 0.1f);
    return mesh;
}

/// The same square twice, the second an ulp of its height nearer to the rays: whoever rounds may err, but never between two.
void ulpApart(Run& run) {
    const char* metric = "speckle where squares are an ulp apart";
    MeshData mesh = test::panel(vec3(-1, -1, 1), vec3(2, 0, 0), vec3(0, 2, 0));
    MeshData second = mesh;
    for (vec3& p : second.positions) p.z = std::nextafter(p.z, 2.0f);
    joinPlain(mesh, second);
    const World world(mesh);
    for (const auto& tracer : tracersOf(world, run)) {
        Random random(141);
        std::vector<Ray> rays;
        for (uint64_t i = 0; i < run.count(100000, 2000000); i++)
            rays.push_back(makeRay(vec3(random.real(-0.9f, 0.9f), random.real(-0.9f, 0.9f), 1.0f + random.real(0.1f, 0.9f)),
                                   vec3(0, 0, -1)));
        std::vector<Met> met;
        tracer->trace(rays, met);
        uint64_t far = 0, missed = 0;
        for (const Met& m : met) far += m.hit() && m.triangle < 2, missed += !m.hit();
        run.rate(tracer->column(), metric, std::min(far, rays.size() - far), rays.size(), 0.05);
        run.rate(tracer->column(), "missed", missed, rays.size(), 0.0);
    }
}

}  // namespace

void coplanar(Run& run) {
    ulpApart(run);
    const char* speckle = "speckle where two squares are cut differently";
    for (const char* judged : {column::OWN, column::EMBREE, column::VULKAN})
        run.known(judged, speckle, 0.5,
                  "only triangles with the same corners have a winner; others tie by rounding (wanted: a depth bias by id)");
    Random random(14);
    for (int shape = 0; shape < 16; shape++) {
        const mat3 turn(glm::rotate(mat4(1.0f), random.real(0.1f, 3.0f), random.direction()));
        std::vector<Ray> rays;
        for (uint64_t i = 0; i < run.count(20000, 500000); i++) {
            const vec3 aim = turn * vec3(random.real(-0.99f, 0.99f), random.real(-0.99f, 0.99f), 0) + vec3(0.3f, 0.2f, 0.1f);
            const vec3 d = random.direction();
            if (std::fabs(glm::dot(d, turn * vec3(0, 0, 1))) > 0.05f) rays.push_back(makeRay(aim - d * 3.0f, d));
        }
        for (bool otherwise : {false, true}) {
            const World world(twoInOne(turn, otherwise));
            for (const auto& tracer : tracersOf(world, run)) {
                std::vector<Met> met;
                tracer->trace(rays, met);
                uint64_t second = 0, missed = 0;
                for (const Met& m : met) second += m.hit() && m.triangle >= 2, missed += !m.hit();
                if (otherwise) run.rate(tracer->column(), speckle, std::min(second, rays.size() - second), rays.size(), 0.05);
                else run.rate(tracer->column(), "not the first of two", second, rays.size(), 0.0);
                run.rate(tracer->column(), "missed", missed, rays.size(), 0.0);
            }
        }
    }
}

namespace {

constexpr int STEPS = 4;  // places of rays to a unit
constexpr int CUBES = 3;  // along each axis: [0, 1], [2, 3], [4, 5]
constexpr int LOW = -STEPS, HIGH = 6 * STEPS;

/// Whether a place on an axis, in steps, lies on a closed cube.
bool onCube(int place) { return place >= 0 && place <= 5 * STEPS && (place % (2 * STEPS)) <= STEPS; }

/// Whether it is on the border of one, from where a component of 1e-38 leads out.
bool onBorder(int place) {
    return onCube(place) && place % STEPS == 0 && (place % (2 * STEPS) == 0 || place % (2 * STEPS) == STEPS);
}

/// Steps to the next face ahead on an axis, 0: none. `sign`: the way.
int nextFace(int from, int sign) {
    for (int place = from + sign; place >= LOW && place <= HIGH; place += sign)
        if (place >= 0 && place <= 5 * STEPS && (place % (2 * STEPS) == 0 || place % (2 * STEPS) == STEPS))
            return std::abs(place - from);
    return 0;
}

MeshData grid() {
    MeshData mesh;
    for (int x = 0; x < CUBES; x++)
        for (int y = 0; y < CUBES; y++)
            for (int z = 0; z < CUBES; z++) joinPlain(mesh, test::box(vec3(x, y, z) * 2.0f, vec3(x, y, z) * 2.0f + 1.0f));
    return mesh;
}

struct AxisRay {
    Ray ray;
    float t;         // 0: meets nothing
    bool ambiguous;  // exactly on a border that it leaves by less than float holds
};

/// Along every axis both ways from every place of the lattice; the other components of the direction are `nothing`.
std::vector<AxisRay> axisRays(float nothing) {
    std::vector<AxisRay> all;
    for (int axis = 0; axis < 3; axis++)
        for (int sign : {-1, 1})
            for (int s = LOW; s <= HIGH; s++)
                for (int u = LOW; u <= HIGH; u++)
                    for (int v = LOW; v <= HIGH; v++) {
                        vec3 origin(0.0f), d(nothing);
                        origin[axis] = float(s) / STEPS;
                        origin[(axis + 1) % 3] = float(u) / STEPS;
                        origin[(axis + 2) % 3] = float(v) / STEPS;
                        d[axis] = float(sign);
                        const bool passes = onCube(u) && onCube(v);
                        all.push_back({makeRay(origin, d), passes ? float(nextFace(s, sign)) / STEPS : 0.0f,
                                       nothing != 0.0f && (onBorder(u) || onBorder(v))});
                    }
    return all;
}

}  // namespace

void axisAligned(Run& run) {
    run.known(column::EMBREE, "missed faces", 0.06, "rays exactly along edges of a body: see vertex_hits");
    run.known(column::EMBREE, "-0 or 1e-38 for 0 changes hits", 0.01, "the same rays");
    const World world(grid());
    for (const auto& tracer : tracersOf(world, run)) {
        std::vector<Met> usual;
        for (float nothing : {0.0f, -0.0f, 1e-38f}) {
            const std::vector<AxisRay> all = axisRays(nothing);
            std::vector<Ray> rays;
            for (const AxisRay& r : all) rays.push_back(r.ray);
            std::vector<Met> met;
            tracer->trace(rays, met);
            uint64_t missed = 0, wrong = 0, differ = 0;
            size_t at = 0, wrongAt = 0;
            for (size_t i = 0; i < all.size(); i++) {
                if (all[i].ambiguous) continue;
                if (all[i].t > 0.0f && !met[i].hit() && missed++ == 0) at = i;
                if (met[i].hit() && !(std::fabs(met[i].t - all[i].t) <= 1e-6f) && wrong++ == 0) wrongAt = i;
                if (!usual.empty()) differ += met[i].hit() != usual[i].hit();
            }
            run.rate(tracer->column(), "missed faces", missed, rays.size(), 0.0, replayOf("axis_aligned", rays[at]));
            run.rate(tracer->column(), "hits elsewhere", wrong, rays.size(), 0.0, replayOf("axis_aligned", rays[wrongAt]));
            if (!usual.empty()) run.rate(tracer->column(), "-0 or 1e-38 for 0 changes hits", differ, rays.size(), 0.0);
            else usual = met;
        }
    }
}

namespace {

/// From inside a ball of radius `size` with directions of length 2^exponent.
std::vector<Ray> outward(Random& random, uint64_t count, float size, int exponent) {
    std::vector<Ray> rays;
    for (uint64_t i = 0; i < count; i++)
        rays.push_back(makeRay(random.inCube(0.3f) * size, random.direction() * std::ldexp(0.5f, exponent)));
    return rays;
}

bool isProduct(const char* column) { return column == column::OWN || column == column::EMBREE || column == column::VULKAN; }
/// Whether such a direction has to be traced. The kernel makes its directions unit; of longer ones the devices let rays meet
/// nothing, and count them.
bool mustBeRight(const char* column, int exponent) { return !isProduct(column) || (exponent <= 0 && exponent >= -20); }
bool mustMeetNothing(const char* column, int exponent) { return isProduct(column) && exponent > 2; }

void sizes(Run& run) {
    for (float size : {1e-40f, 1e-30f, 1e-20f, 1e-10f, 1.0f, 1e10f, 1e15f}) {
        MeshData mesh = test::icosphere(3);
        for (vec3& p : mesh.positions) p *= size;
        const World world(mesh);
        char name[32];
        std::snprintf(name, sizeof name, "%g", double(size));
        if (!world.taken()) run.note(std::string("a ball of ") + name + " is refused: " + world.scene()->warnings.front());
        for (const auto& tracer : tracersOf(world, run)) {
            Random random(17);
            const std::vector<Ray> rays = outward(random, run.count(20000, 1000000), size, 0);
            std::vector<Met> met;
            tracer->trace(rays, met);
            uint64_t leaks = 0, bad = 0;
            for (const Met& m : met) leaks += !m.hit(), bad += m.hit() && !std::isfinite(m.t);
            run.rate(tracer->column(), std::string("leaks from a ball of ") + name, leaks, rays.size(), 0.0);
            run.rate(tracer->column(), "distance not finite", bad, rays.size(), 0.0);
        }
    }
}

void lengths(Run& run) {
    const World world(test::icosphere(3));
    for (const auto& tracer : tracersOf(world, run)) {
        for (int exponent : {-98, -60, -20, 0, 20, 60, 100}) {
            Random random(171);
            const std::vector<Ray> unit = outward(random, run.count(20000, 1000000), 1.0f, 0);
            random = Random(171);
            std::vector<Ray> rays = outward(random, unit.size(), 1.0f, exponent);
            std::vector<Met> usual, met;
            tracer->trace(unit, usual);
            tracer->trace(rays, met);
            uint64_t wrong = 0, taken = 0;
            for (size_t i = 0; i < rays.size(); i++) {
                taken += met[i].hit() && mustMeetNothing(tracer->column(), exponent);
                if (!mustBeRight(tracer->column(), exponent)) continue;
                const double t = double(met[i].t) * std::ldexp(1.0, exponent);
                wrong += met[i].hit() != usual[i].hit() || (met[i].hit() && !(std::fabs(t / usual[i].t - 1.0) <= 1e-4));
            }
            run.rate(tracer->column(), "length of the direction matters", wrong, rays.size(), 0.0);
            run.rate(tracer->column(), "traced though out of reach", taken, rays.size(), 0.0);
        }
    }
}

void ends(Run& run) {
    const World world(test::icosphere(3));
    const float infinite = std::numeric_limits<float>::infinity(), none = std::numeric_limits<float>::quiet_NaN();
    for (const auto& tracer : tracersOf(world, run)) {
        Random random(172);
        std::vector<Ray> rays = outward(random, 4000, 1.0f, 0);
        for (size_t i = 0; i < rays.size(); i++)
            rays[i].tMax = i % 4 == 0 ? infinite : i % 4 == 1 ? 0.0f : i % 4 == 2 ? 0x1p-140f : none;
        std::vector<Met> met;
        tracer->trace(rays, met);
        uint64_t wrong = 0;
        for (size_t i = 0; i < rays.size(); i++) wrong += met[i].hit() != (i % 4 == 0);
        run.rate(tracer->column(), "wrong with an end of inf, 0, denormal, NaN", wrong, rays.size(), 0.0);
    }
}

}  // namespace

void extremes(Run& run) {
    run.known(column::EMBREE, "leaks from a ball of 1e+15", 1.0, "Embree's products leave float beyond 1e12");
    run.note("directions shorter than 2^-20 are judged beside the product only: the kernel makes its directions unit");
    sizes(run);
    lengths(run);
    ends(run);
}

}  // namespace heliograph::hard

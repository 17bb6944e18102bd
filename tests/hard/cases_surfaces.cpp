// Cases 11, 24, 26, 27 and 29: triangles, normals and transforms that files really hold, and corners.

#include "tests/hard/cases.h"
#include "tests/hard/painter.h"
#include "tests/hard/tracer.h"

#include <glm/gtc/matrix_transform.hpp>

namespace heliograph::hard {

namespace {

using namespace test;

Camera viewer() { return lookAt(vec3(0.1f, 0.7f, 5), vec3(0.0f)); }

std::shared_ptr<const Scene> paintedBall(const MeshData& mesh) {
    SceneBuilder builder = darkness(vec3(0.5f));
    place(builder, mesh);
    builder.addLight(pointLight(vec3(1, 4, 3), vec3(30.0f)));
    return builder.finish();
}

/// A strip of `count` triangles of length 1 and width 1e-7.
MeshData strip(uint32_t count) {
    MeshData mesh;
    for (uint32_t i = 0; i <= count; i++)
        mesh.positions.insert(mesh.positions.end(), {vec3(float(i) * 1e-7f, 0, 0), vec3(float(i) * 1e-7f, 1, 0)});
    for (uint32_t i = 0; i < count; i++) {
        mesh.indices.push_back({2 * i, 2 * i + 2, 2 * i + 3});
        mesh.indices.push_back({2 * i, 2 * i + 3, 2 * i + 1});
    }
    mesh.materials.assign(mesh.indices.size(), 0u);
    return mesh;
}

/// The mesh among ten thousand triangles without area.
MeshData amongDegenerates(MeshData mesh) {
    Random random(2);
    for (int i = 0; i < 10000; i++) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        const vec3 p = random.inCube(2.0f), d = random.direction();
        mesh.positions.insert(mesh.positions.end(), {p, i % 2 ? p : p + d, i % 3 ? p : p + d});
        mesh.normals.insert(mesh.normals.end(), 3, vec3(0, 1, 0));
        mesh.indices.push_back({first, first + 1, first + 2});
        mesh.materials.push_back(0u);
    }
    return mesh;
}

}  // namespace

void slivers(Run& run) {
    const uint32_t count = 200;
    const World world(strip(count));
    for (const auto& tracer : tracersOf(world, run)) {
        Random random(11);
        std::vector<Ray> rays;
        for (uint64_t i = 0; i < run.count(200000, 10000000); i++) {
            const vec3 aim(random.real(0.05f, 0.95f) * float(count) * 1e-7f, random.real(0.05f, 0.95f), 0);
            rays.push_back(makeRay(aim + vec3(0, 0, random.real(0.5f, 2.0f)), vec3(0, 0, -1)));
        }
        std::vector<Met> met;
        tracer->trace(rays, met);
        uint64_t leaks = 0, bad = 0;
        for (const Met& m : met) leaks += !m.hit(), bad += m.hit() && !std::isfinite(m.t);
        run.rate(tracer->column(), "leaks through slivers of 1e7", leaks, rays.size(), 0.0);
        run.rate(tracer->column(), "distance not finite", bad, rays.size(), 0.0);
    }
    for (const Painter& painter : painters(run)) {
        const Picture clean = draw(painter, paintedBall(icosphere(3)), viewer());
        const Picture dirty = draw(painter, paintedBall(amongDegenerates(icosphere(3))), viewer());
        countBad(run, painter, dirty);
        run.rate(painter.column, "pixels changed by triangles without area", differing(clean, dirty, 0.0), clean.pixels.size(),
                 0.0);
    }
}

namespace {

/// Where a shadow ray begins: the product's starts on the smooth surface (Hanika), the others on the facet.
Ray shadowRay(const World& world, const Tracer& tracer, const Ray& ray, const Met& met, vec3 toLight) {
    if (std::string(tracer.column()) != column::OWN) return tracer.leave(ray, met, toLight);
    const auto s = world.surface(ray, met);
    return makeRay(world.kernel().offsetRayOrigin(s.shadowPosition, s.geometricNormal, s.clearance), toLight);
}

}  // namespace

void terminator(Run& run) {
    const char* metric = "mean error of the lit share, 60 to 90 degrees";
    const World world(icosphere(2));
    for (const auto& tracer : tracersOf(world, run)) {
        const std::string name = tracer->column();
        if (name == column::EMBREE || name == column::VULKAN) continue;  // by pictures
        Random random(24);
        std::vector<Ray> rays, shadows;
        for (int i = 0; i < 100000; i++) {
            const vec3 d = random.direction();
            rays.push_back(makeRay(d * 4.0f, -d));
        }
        std::vector<Met> met, blocked;
        tracer->trace(rays, met);
        std::vector<double> lit;
        for (size_t i = 0; i < rays.size(); i++) {
            const vec3 toLight = random.direction();
            const double cosine = met[i].hit() ? glm::dot(world.surface(rays[i], met[i]).normal, toLight) : -1.0;
            if (cosine <= 0.0 || cosine > 0.5) continue;
            shadows.push_back(shadowRay(world, *tracer, rays[i], met[i], toLight));
            lit.push_back(cosine);
        }
        tracer->trace(shadows, blocked);
        double sum = 0.0, worst = 0.0;
        for (size_t i = 0; i < lit.size(); i++) {
            sum += blocked[i].hit() ? lit[i] : 0.0;
            worst = std::max(worst, blocked[i].hit() ? lit[i] : 0.0);
        }
        run.most(tracer->column(), "greatest lit share that is dark", worst, 0.02, lit.size());
        run.most(tracer->column(), metric, sum / double(lit.size()), 0.02, lit.size());
    }
    for (const Painter& painter : painters(run)) {
        SceneBuilder builder = darkness();
        place(builder, icosphere(2, builder.addMaterial(paint(vec3(1.0f)), "white")));
        const vec3 down = glm::normalize(vec3(-1.0f, -0.3f, -0.2f));
        builder.addLight(sun(down, vec3(float(EXACT_PI))));
        const Picture p = draw(painter, builder.finish(), viewer());
        double sum = 0.0;
        uint64_t n = 0, dark = 0;
        for (uint32_t y = 0; y < p.size.y; y++)
            for (uint32_t x = 0; x < p.size.x; x++) {
                const dvec3 d = rayThrough(viewer(), p.size, x, y), o(viewer().position);
                const double t = meetsUnitSphere(o, d), cosine = t > 0.0 ? glm::dot(o + d * t, -dvec3(down)) : -1.0;
                if (cosine <= 0.0 || cosine > 0.5 || glm::dot(o + d * t, d) > -0.3) continue;  // not at the facets' outline
                sum += std::fabs(p.at(x, y).x - cosine);
                dark += p.at(x, y).x == 0.0f && cosine > 0.02;
                n++;
            }
        run.most(painter.column, metric, sum / double(n), 0.02, n);
        run.rate(painter.column, "lit pixels that are dark", dark, n, 0.0);
    }
}

void badAttributes(Run& run) {
    const vec3 bad[] = {vec3(0.0f), vec3(NAN, 1, 0), vec3(INFINITY, 0, 0)};
    uint64_t naive = 0;
    MeshData mesh = icosphere(3);
    for (size_t i = 0; i < mesh.normals.size(); i += 3) {
        mesh.normals[i] = bad[i / 3 % 3];
        const vec3 n = glm::normalize(mesh.normals[i]);
        naive += !(std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z));
    }
    run.rate(column::NAIVE, "not finite", naive, mesh.normals.size(), 0.0);
    for (vec3 p : mesh.positions) mesh.uv0.emplace_back(p.x > 0 ? NAN : 1e30f, p.y);
    for (size_t i = 0; i < mesh.positions.size(); i++) mesh.tangents.emplace_back(i % 2 ? vec4(0.0f) : vec4(NAN, 1, 0, 2.0f));
    MeshData holes = mesh;
    holes.positions[5] = vec3(NAN);
    holes.positions[9].y = INFINITY;
    const auto scene = paintedBall(mesh), holed = paintedBall(holes), sound = paintedBall(icosphere(3));
    for (const Painter& painter : painters(run)) {
        run.rate(painter.column, "replaced without a word", scene->warnings.empty() + holed->warnings.empty(), 2, 0.0);
        const Picture a = draw(painter, scene, viewer()), b = draw(painter, holed, viewer());
        countBad(run, painter, a);
        countBad(run, painter, b);
        // Normals made from the triangles are a ball's to a degree or so; a normal that is used as it stands is off by tens.
        run.rate(painter.column, "pixels off the sound body's by 5 %", differing(a, draw(painter, sound, viewer()), 0.05),
                 a.pixels.size(), 0.01);
        // Two vertices of 642, with the dozen triangles about them and the normals made of those.
        run.rate(painter.column, "pixels changed by two lost vertices", differing(a, b, 1e-4), a.pixels.size(), 0.05);
    }
}

namespace {

std::vector<mat4> transforms() {
    mat4 deep(1.0f), shear(1.0f);
    for (int i = 0; i < 40; i++) deep = deep * glm::rotate(mat4(1.0f), 0.7f, glm::normalize(vec3(1, i % 3, 2)));
    shear[1][0] = 3.0f;
    return {glm::scale(mat4(1.0f), vec3(1, 1, -1)), glm::scale(mat4(1.0f), vec3(1e-3f, 1, 1e3f)), shear, deep,
            glm::rotate(glm::scale(mat4(1.0f), vec3(-2, 0.1f, 5)), 1.0f, glm::normalize(vec3(1, 2, 3)))};
}

/// Degrees between a facet's normal by the kernel and in double; and by a matrix that is not transposed.
struct Tilts {
    double own = 0.0, naive = 0.0;
};

double degrees(dvec3 a, dvec3 b) {
    return std::atan2(glm::length(glm::cross(a, b)), std::fabs(glm::dot(a, b))) * 180.0 / EXACT_PI;
}

Tilts tiltsOf(const mat4& m, uint32_t triangle) {
    static const MeshData body = icosphere(2);
    SceneBuilder builder = darkness();
    const uint32_t mesh = builder.addMesh(body);
    builder.addInstance(mesh, m);
    builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(5000, 0, 0)));
    const auto scene = builder.finish();
    test::EveryKernel kernel = bareKernel();
    kernel.scene = sceneView(*scene);
    kernel.frame.effects = EFFECT_INSTANCING;
    const uvec3 t = body.indices[triangle];
    const glm::dmat4 exact(m);
    dvec3 p[3], normal(0.0);
    for (int k = 0; k < 3; k++) {
        p[k] = dvec3(exact * glm::dvec4(dvec3(body.positions[t[k]]), 1.0));
        normal += glm::normalize(glm::transpose(glm::inverse(glm::dmat3(exact))) * dvec3(body.normals[t[k]])) / 3.0;
    }
    const dvec3 facet = glm::cross(p[1] - p[0], p[2] - p[0]),
                out = glm::normalize(glm::dot(facet, normal) < 0.0 ? -facet : facet);
    const dvec3 middle = (p[0] + p[1] + p[2]) / 3.0;
    const auto s = kernel.surfaceAt(vec3(middle + out), vec3(-out), 0.0f, 0.0f, Hit{0, triangle});
    const dvec3 plain = dvec3(glm::dmat3(exact) * dvec3(body.normals[t.x]));
    const dvec3 right = glm::transpose(glm::inverse(glm::dmat3(exact))) * dvec3(body.normals[t.x]);
    return {std::max(degrees(dvec3(s.geometricNormal), out), glm::dot(dvec3(s.geometricNormal), out) > 0.0 ? 0.0 : 180.0),
            degrees(plain, right)};
}

}  // namespace

void transformed(Run& run) {
    Random random(27);
    for (const mat4& m : transforms()) {
        for (uint64_t i = 0; i < run.count(40, 1000); i++) {
            const Tilts tilts = tiltsOf(m, random.below(320));
            run.most(column::OWN, "degrees off the normal", tilts.own, 0.01, 1);
            run.most(column::NAIVE, "degrees off the normal", tilts.naive, 0.01, 1);
        }
    }
    for (const Painter& painter : painters(run)) {
        for (vec3 scale : {vec3(1, 0, 1), vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, -1), vec3(1e-3f, 1, 1e3f)}) {
            SceneBuilder builder = darkness(vec3(0.5f));
            const uint32_t mesh = builder.addMesh(icosphere(2));
            builder.addInstance(mesh, glm::scale(mat4(1.0f), scale));
            builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(2.5f, 0, 0)));
            builder.addLight(pointLight(vec3(1, 4, 3), vec3(30.0f)));
            countBad(run, painter, draw(painter, builder.finish(), viewer()));
        }
    }
}

namespace {

/// Cosine-distributed rays from the floor at distance `d` of the wall x = 0.
std::vector<Ray> fromCorner(const Tracer& tracer, Random& random, float d, uint64_t count) {
    std::vector<Ray> rays;
    for (uint64_t i = 0; i < count; i++) {
        const vec3 foot(d, 0, random.real(-0.3f, 0.3f));
        const Ray down = makeRay(foot + vec3(0, d, 0), vec3(0, -1, 0));
        const Met m{foot.z < foot.x ? 0u : 1u, d};
        const double r = std::sqrt(random.number(0.0, 1.0)), turn = random.number(0.0, 2.0 * EXACT_PI);
        const vec3 towards(float(r * std::cos(turn)), float(std::sqrt(1.0 - r * r)), float(r * std::sin(turn)));
        rays.push_back(tracer.leave(down, m, glm::normalize(towards)));
    }
    return rays;
}

void closedBox(Run& run) {
    const World world(insideOut(box(vec3(-1.0f), vec3(1.0f))));
    for (const auto& tracer : tracersOf(world, run)) {
        Random random(291);
        std::vector<Ray> first, next;
        for (uint64_t i = 0; i < run.count(500000, 20000000); i++) {
            // From close by, into an edge.
            const vec3 foot(-1.0f + float(random.magnitude(1e-6, 1.0)), 0, random.real(-0.9f, 0.9f));
            first.push_back(makeRay(foot, vec3(0, -1, 0)));
        }
        std::vector<Met> met, after;
        tracer->trace(first, met);
        for (size_t i = 0; i < first.size(); i++) {
            vec3 d = random.direction();
            d.y = std::fabs(d.y) + 1e-4f;
            if (met[i].hit()) next.push_back(tracer->leave(first[i], met[i], glm::normalize(d)));
        }
        tracer->trace(next, after);
        uint64_t leaks = first.size() - next.size();
        size_t at = 0;
        for (size_t i = 0; i < next.size(); i++)
            if (!after[i].hit() && leaks++ == 0) at = i;
        run.rate(tracer->column(), "leaks of a closed box", leaks, first.size(), 1e-6, replayOf("corners", next[at]));
    }
}

}  // namespace

void corners(Run& run) {
    MeshData mesh = panel(vec3(0, 0, 1), vec3(1, 0, 0), vec3(0, 0, -2));  // floor; triangles 0 and 1
    mesh.positions.insert(mesh.positions.end(), {{0, 0, -1000}, {0, 1000, -1000}, {0, 1000, 1000}, {0, 0, 1000}});
    mesh.indices = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
    mesh.materials.assign(4, 0u);
    mesh.normals.clear(), mesh.uv0.clear();
    const World world(mesh);
    for (const auto& tracer : tracersOf(world, run)) {
        Random random(29);
        for (float d : {0.5f, 0.1f, 1e-2f, 1e-3f, 1e-4f}) {
            const std::vector<Ray> rays = fromCorner(*tracer, random, d, run.count(100000, 2000000));
            std::vector<Met> met;
            tracer->trace(rays, met);
            uint64_t open = 0;
            for (const Met& m : met) open += !m.hit();
            run.most(tracer->column(), "visibility off 0.5", std::fabs(double(open) / double(rays.size()) - 0.5), 0.01,
                     rays.size());
        }
    }
    closedBox(run);
}

}  // namespace heliograph::hard

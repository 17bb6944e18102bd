// Cases 19, 20, 22, 23 and 37: where light has to be neither lost nor made.

#include "tests/hard/cases.h"
#include "tests/hard/painter.h"
#include "tests/hard/tracer.h"

#include <glm/gtc/matrix_transform.hpp>

namespace heliograph::hard {

namespace {

using namespace test;

Settings deep(uint32_t depth) {
    Settings settings;
    settings.maxReflections = settings.maxRefractions = depth;
    return settings;
}

Camera front() { return lookAt(vec3(0, 0, 5), vec3(0.0f)); }

/// Stripes that glow, at z = -3, none of whose edges is aimed at by a pixel's centre, before which a body may stand.
std::shared_ptr<const Scene> before(const std::optional<Material>& material) {
    SceneBuilder builder = darkness();
    for (int i = -20; i < 20; i++) {
        const uint32_t paint = builder.addMaterial(glow(vec3(i % 2 ? 0.2f : 1.0f)), "stripe");
        place(builder, panel(vec3(float(i) * 0.5f + 0.1371f, -10, -3), vec3(0.5f, 0, 0), vec3(0, 20, 0), paint));
    }
    if (material) place(builder, icosphere(3, builder.addMaterial(*material, "body")));
    return builder.finish();
}

double greatestDifference(const Picture& a, const Picture& b) {
    double most = 0.0;
    for (size_t i = 0; i < a.pixels.size(); i++)
        most = std::max(most, std::fabs(double(a.pixels[i].x) - double(b.pixels[i].x)));
    return most;
}

}  // namespace

void indexNearOne(Run& run) {
    // Schlick's reflectance has all light turned back at the rim, whatever the index.
    double naive = 0.0;
    for (int i = 0; i <= 100; i++) naive = std::max(naive, std::pow(1.0 - 0.01 * i, 5.0));
    run.most(column::NAIVE, "pixel difference with an index of 1", naive, 1e-3, 101);
    for (const Painter& painter : painters(run)) {
        const Picture without = draw(painter, before(std::nullopt), front(), deep(8));
        const Picture one = draw(painter, before(glass(1.0f)), front(), deep(8));
        run.most(painter.column, "pixel difference with an index of 1", greatestDifference(without, one), 1e-3,
                 one.pixels.size());
        for (float index : {1.0f - 1e-7f, 1.0f + 1e-7f}) {
            const Picture near = draw(painter, before(glass(index)), front(), deep(8));
            run.rate(painter.column, "pixels off with an index of 1 +- 1e-7", differing(without, near, 1e-2),
                     near.pixels.size(), 1e-2);
        }
        for (float index : {1.0f / 1.5f, 0.0f, -1.0f, NAN, 1e6f})
            countBad(run, painter, draw(painter, before(glass(index)), front(), deep(8)));
    }
}

namespace {

/// Radiance through or off a pane of index 1.5, of a lamp of 1 behind or beside the camera; everything else is black.
double paneShows(const Painter& painter, bool through) {
    SceneBuilder builder = darkness();
    place(builder, box(vec3(-50, -50, -0.05f), vec3(50, 50, 0.05f), builder.addMaterial(glass(1.5f), "pane")));
    const uint32_t lamp = builder.addMaterial(glow(vec3(1.0f)), "lamp");
    if (through) place(builder, panel(vec3(-50, -50, -2), vec3(100, 0, 0), vec3(0, 100, 0), lamp));
    else place(builder, panel(vec3(50, -50, 6), vec3(-100, 0, 0), vec3(0, 100, 0), lamp));
    return draw(painter, builder.finish(), lookAt(vec3(0, 0, 5), vec3(0.0f), 1.0f), deep(24), 1, uvec2(9, 9)).centre().x;
}

}  // namespace

void slabEnergy(Run& run) {
    const double f0 = 0.04, reflected = 2.0 * f0 / (1.0 + f0);
    // One interface for the whole pane.
    run.most(column::NAIVE, "T off the series", std::fabs((1.0 - f0) - (1.0 - reflected)), 1e-3, 1);
    for (const Painter& painter : painters(run)) {
        run.most(painter.column, "T off the series", std::fabs(paneShows(painter, true) - (1.0 - reflected)), 1e-3, 1);
        run.most(painter.column, "R off the series", std::fabs(paneShows(painter, false) - reflected), 1e-3, 1);
        SceneBuilder builder = darkness(vec3(1.0f));
        place(builder, box(vec3(-1, -1, -0.2f), vec3(1, 1, 0.2f), builder.addMaterial(glass(1.5f), "pane")),
              glm::rotate(mat4(1.0f), 0.4f, vec3(0.3f, 1, 0)));
        const Picture even = draw(painter, builder.finish(), front(), deep(8));
        double most = 0.0;
        for (vec4 p : even.pixels) most = std::max(most, std::fabs(double(p.x) - 1.0));
        run.most(painter.column, "furnace at depth 8", most, 1e-3, even.pixels.size());
    }
}

void absorption(Run& run) {
    const vec3 sigma(0.4f, 0.9f, 2.0f);
    for (vec3 scale : {vec3(1.0f), vec3(2.5f), vec3(0.3f, 1.0f, 3.0f), vec3(1.0f, 4.0f, 0.1f)}) {
        const glm::dvec3 exact = glm::exp(-glm::dvec3(sigma) * (2.0 * double(scale.z)));
        const auto off = [&](glm::dvec3 seen) {
            double most = 0.0;
            for (int c = 0; c < 3; c++) most = std::max(most, std::fabs(seen[c] / exact[c] - 1.0));
            return most;
        };
        // The thickness as the file has it, before the node's scale.
        run.most(column::NAIVE, "off exp(-sigma d), relative", off(glm::exp(-glm::dvec3(sigma) * 2.0)), 1e-2, 3);
        for (const Painter& painter : painters(run)) {
            for (bool placed : {false, true}) {
                SceneBuilder builder = darkness(vec3(1.0f));
                Material m = glass(1.0f);
                m.absorption = vec4(sigma, 0.0f);
                const uint32_t mesh = builder.addMesh(box(vec3(-1.0f), vec3(1.0f), builder.addMaterial(m, "cube")));
                builder.addInstance(mesh, glm::scale(mat4(1.0f), scale));
                if (placed) builder.addInstance(mesh, glm::translate(mat4(1.0f), vec3(100, 0, 0)));
                const Picture p =
                    draw(painter, builder.finish(), lookAt(vec3(0, 0, 10), vec3(0.0f), 2.0f), deep(8), 1, uvec2(9, 9));
                run.most(painter.column, "off exp(-sigma d), relative", off(glm::dvec3(p.centre())), 1e-2, 3);
            }
        }
    }
}

void parallelMirrors(Run& run) {
    const float gap = 0.005f;  // less than the naive tracer's epsilon
    MeshData both = panel(vec3(-10, 0, 10), vec3(20, 0, 0), vec3(0, 0, -20));
    both.positions.insert(both.positions.end(), {{-10, gap, -10}, {10, gap, -10}, {10, gap, 10}, {-10, gap, 10}});
    both.indices.insert(both.indices.end(), {{4, 5, 6}, {4, 6, 7}});
    both.materials.assign(4, 0u);
    both.normals.clear(), both.uv0.clear();
    const World world(both);
    std::vector<Ray> rays(1000, makeRay(vec3(0.1f, gap * 0.5f, 0.2f), vec3(0, -1, 0)));
    std::vector<Met> met;
    naiveTracer(world)->trace(rays, met);
    uint64_t missed = 0;
    for (const Met& m : met) missed += !m.hit();
    run.rate(column::NAIVE, "mirrors missed", missed, rays.size(), 0.0);
    for (const Painter& painter : painters(run)) {
        for (float height : {2.0f, gap}) {
            const double rho = 0.8;
            SceneBuilder builder = darkness();
            Material m = mirror(float(rho));
            m.emission = vec4(1.0f, 1.0f, 1.0f, 0.0f);
            const uint32_t material = builder.addMaterial(m, "mirror");
            place(builder, ground(10.0f, material));
            place(builder, panel(vec3(-10, height, -10), vec3(20, 0, 0), vec3(0, 0, 20), material));
            const auto scene = builder.finish();
            for (uint32_t depth : {1u, 4u, 31u}) {
                const Camera camera = lookAt(vec3(0.1f, height * 0.5f, 0.2f), vec3(0.1f, 0, 0.2f), 10.0f);
                const double seen = draw(painter, scene, camera, deep(depth), 1, uvec2(9, 9)).centre().x;
                const double exact = (1.0 - std::pow(rho, depth + 1)) / (1.0 - rho);
                run.most(painter.column, "off the geometric sum, relative", std::fabs(seen / exact - 1.0), 1e-4, 1);
            }
        }
    }
}

void furnace(Run& run) {
    // Diffuse and Schlick's reflection added up, neither knowing of the other.
    run.most(column::NAIVE, "brightest - 1", 1.0, 1e-3, 1);
    std::vector<std::pair<const char*, Material>> bodies = {{"diffuse", paint(vec3(1.0f))}, {"glass", glass(1.5f)}};
    for (int i = 0; i <= 10; i++) {
        for (float metallic : {0.0f, 1.0f}) {
            Material m = SceneBuilder::defaultMaterial();
            m.baseColor = vec4(1.0f);
            m.metallic = metallic;
            m.roughness = 0.1f * float(i);
            bodies.emplace_back("rough", m);
        }
    }
    for (const Painter& painter : painters(run)) {
        double rough = 0.0;
        for (const auto& [name, material] : bodies) {
            SceneBuilder builder = darkness(vec3(1.0f));
            place(builder, icosphere(4, builder.addMaterial(material, name)));
            const Picture p = draw(painter, builder.finish(), lookAt(vec3(0, 0, 4), vec3(0.0f)), deep(16));
            double most = -1.0, least = 2.0;
            for (vec4 v : p.pixels) most = std::max(most, double(v.x)), least = std::min(least, double(v.x));
            countBad(run, painter, p);
            run.most(painter.column, "brightest - 1", most - 1.0, 1e-3, p.pixels.size());
            if (std::string(name) != "rough")
                run.most(painter.column, "1 - darkest, diffuse and glass", 1.0 - least, 1e-3, p.pixels.size());
            else rough = std::max(rough, 1.0 - least);
        }
        run.note(std::string(painter.column) + ": the darkest rough body loses " + std::to_string(rough));
    }
}

}  // namespace heliograph::hard

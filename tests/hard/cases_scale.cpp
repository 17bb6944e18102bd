// Cases 1, 2 and 3: the same scene elsewhere and in other units.

#include "tests/hard/cases.h"
#include "tests/hard/painter.h"
#include "tests/hard/tracer.h"

#include <glm/gtc/matrix_transform.hpp>

namespace heliograph::hard {

namespace {

using namespace test;

constexpr vec3 FAR(1e6f, 1e6f, 1e6f);

/// A ball of facets that glow each in a colour of its own, so that colours tell which one was met; or a painted one, lit.
std::shared_ptr<const Scene> ball(vec3 at, bool lit) {
    SceneBuilder builder = darkness();
    MeshData mesh = icosphere(3);
    Random random(1);
    for (uint32_t& material : mesh.materials) {
        const vec3 color(random.real(0.1f, 1), random.real(0.1f, 1), random.real(0.1f, 1));
        material = builder.addMaterial(lit ? paint(color) : glow(color), "facet");
    }
    place(builder, mesh, glm::translate(mat4(1.0f), at));
    if (lit) builder.addLight(pointLight(at + vec3(2, 4, 4), vec3(30.0f)));
    return builder.finish();
}

Camera before(vec3 at) {
    Camera camera = lookAt(vec3(0, 0, 5), vec3(0.0f));
    camera.position += at;
    return camera;
}

/// Rays of a picture of 200 x 200 towards a unit ball at `at`, by naive arithmetic in float.
std::vector<Ray> viewOf(vec3 at, float scale) {
    std::vector<Ray> rays;
    for (int y = 0; y < 200; y++)
        for (int x = 0; x < 200; x++) {
            const vec3 d(float(x - 100) * 0.003f, float(y - 100) * 0.003f, -1.0f);
            rays.push_back(makeRay(at + vec3(0, 0, 5) * scale, glm::normalize(d)));
        }
    return rays;
}

/// How many of the naive tracer's answers change when the ball is moved and scaled.
void countNaive(Run& run, const char* metric, vec3 at, float scale, double bound) {
    const World usual(icosphere(3));
    MeshData mesh = icosphere(3);
    for (vec3& p : mesh.positions) p = p * scale + at;
    const World other(mesh);
    std::vector<Met> a, b;
    naiveTracer(usual)->trace(viewOf(vec3(0.0f), 1.0f), a);
    naiveTracer(other)->trace(viewOf(at, scale), b);
    uint64_t changed = 0;
    for (size_t i = 0; i < a.size(); i++) changed += a[i].triangle != b[i].triangle;
    run.rate(column::NAIVE, metric, changed, a.size(), bound);
}

/// A ball of glass on a floor in the unit 2^exponent.
std::shared_ptr<const Scene> scaled(float scale) {
    SceneBuilder builder = darkness(vec3(0.5f));
    const mat4 m = glm::scale(mat4(1.0f), vec3(scale));
    place(builder, ground(6.0f, builder.addMaterial(paint(vec3(0.8f)), "white"), -1.0f), m);
    place(builder, icosphere(3, builder.addMaterial(glass(1.5f), "glass")), m);
    builder.addLight(pointLight(vec3(2, 4, 3) * scale, vec3(30.0f) * scale * scale));
    return builder.finish();
}

Picture drawScaled(const Painter& painter, float scale) {
    Settings settings;
    settings.maxReflections = 4;
    return draw(painter, scaled(scale), lookAt(vec3(0, 1, 6) * scale, vec3(0.0f)), settings);
}

}  // namespace

void farOrigin(Run& run) {
    const char* ids = "triangles other than at the origin";
    countNaive(run, ids, FAR, 1.0f, 1e-3);
    for (const Painter& painter : painters(run)) {
        const char* shaded = "shaded pixels off by 1 %";
        run.known(painter.column, shaded, 1.0, "surfaces are shaded in world space, in float (wanted: rebased to the camera)");
        const Picture here = draw(painter, ball(vec3(0.0f), false), before(vec3(0.0f)));
        const Picture there = draw(painter, ball(FAR, false), before(FAR));
        countBad(run, painter, there);
        run.rate(painter.column, ids, differing(here, there, 1e-6), here.pixels.size(), 1e-3);
        const Picture lit = draw(painter, ball(vec3(0.0f), true), before(vec3(0.0f)));
        const Picture litThere = draw(painter, ball(FAR, true), before(FAR));
        run.rate(painter.column, shaded, differing(lit, litThere, 0.01), lit.pixels.size(), 1e-3);
    }
}

void tinyScene(Run& run) {
    const char* changed = "pixels other than at scale 2";
    for (int exponent : {-20, -40}) countNaive(run, changed, vec3(0.0f), std::ldexp(1.0f, exponent), 0.0);
    for (const Painter& painter : painters(run)) {
        const Picture usual = drawScaled(painter, 2.0f);
        const Picture tiny = drawScaled(painter, 0x1p-20f), least = drawScaled(painter, 0x1p-40f);
        run.rate(painter.column, changed, differing(usual, tiny, 0.0), usual.pixels.size(), 0.0);
        run.most(painter.column, "mean at 2^-40, relative", std::fabs(meanOf(least) / meanOf(usual) - 1.0), 5e-3, 1);
    }
}

void scaleSweep(Run& run) {
    const char* mean = "mean off scale 2, relative";
    run.known(column::EMBREE, mean, 0.1, "Embree's products leave float beyond 1e12: at 2^40 parts of the floor are missed");
    for (int exponent = -40; exponent <= 40; exponent += 4) {
        countNaive(run, "triangles other than at scale 1", vec3(0.0f), std::ldexp(1.0f, exponent), 5e-3);
        for (const Painter& painter : painters(run)) {
            const Picture picture = drawScaled(painter, std::ldexp(1.0f, exponent));
            countBad(run, painter, picture);
            const double usual = meanOf(drawScaled(painter, 2.0f));
            run.most(painter.column, mean, std::fabs(meanOf(picture) / usual - 1.0), 5e-3, 1,
                     "hard_cases --case scale_sweep (2^" + std::to_string(exponent) + ")");
        }
    }
}

}  // namespace heliograph::hard

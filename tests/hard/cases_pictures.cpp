// Cases 28, 33, 36 and 38: lights and cameras in odd places, samples that are no numbers, and devices against each other.

#include "server/scene/load/scene_source.h"
#include "tests/hard/cases.h"
#include "tests/hard/painter.h"
#include "tests/hard/tracer.h"

#include <bit>
#include <cstring>

namespace heliograph::hard {

namespace {

using namespace test;

/// A lamp of radiance 1 and 2a x 2b metres at height h, that shines down.
Light ceilingLamp(float a, float b, float h) {
    Light light{};
    light.type = LIGHT_QUAD;
    light.position = vec3(0, h, 0);
    light.direction = vec3(0, -1, 0);
    light.edge = vec3(a, 0, 0);
    light.aspect = a > 0.0f ? b / a : 1.0f;
    light.intensity = vec3(4.0f * a * b);
    return light;
}

/// Share of a rectangle's light that arrives under its middle (Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3).
double formFactor(double a, double b, double h) {
    const double x = a / h, y = b / h, rx = std::sqrt(1.0 + x * x), ry = std::sqrt(1.0 + y * y);
    return 4.0 / (2.0 * EXACT_PI) * (x / rx * std::atan(y / rx) + y / ry * std::atan(x / ry));
}

void lampInCeiling(Run& run, const Painter& painter) {
    SceneBuilder builder = darkness();
    const uint32_t white = builder.addMaterial(paint(vec3(1.0f)), "white");
    place(builder, ground(4.0f, white));
    place(builder, panel(vec3(-4, 2, -4), vec3(8, 0, 0), vec3(0, 0, 8), white));
    builder.addLight(ceilingLamp(0.5f, 0.8f, 2.0f));
    const auto scene = builder.finish();
    Settings settings;
    settings.shadowSamples = 64;
    const Picture under = draw(painter, scene, lookAt(vec3(0, 1, 1), vec3(0, 0, 0), 1.0f), settings, 64, uvec2(9, 9));
    run.most(painter.column, "form factor, relative", std::fabs(double(under.centre().x) / formFactor(0.5, 0.8, 2.0) - 1.0),
             5e-3, 64 * 64);
    const Picture above = draw(painter, scene, lookAt(vec3(0, 5, 1), vec3(0, 2, 0), 50.0f), settings, 4);
    uint64_t leaks = 0;
    for (vec4 p : above.pixels) leaks += p.x > 1e-6f * under.centre().x;
    run.rate(painter.column, "pixels lit through the ceiling, over 1e-6 of the floor", leaks, above.pixels.size(), 0.0);
}

}  // namespace

void lightsOnSurfaces(Run& run) {
    const float distance = 0.0f;
    run.rate(column::NAIVE, "not finite", !std::isfinite(1.0f / (distance * distance)), 1, 0.0);
    for (const Painter& painter : painters(run)) {
        SceneBuilder builder = darkness(vec3(0.5f));
        place(builder, ground(3.0f, builder.addMaterial(paint(vec3(1.0f)), "white")));
        builder.addLight(pointLight(vec3(0, 0, 0), vec3(1.0f)));  // exactly on the floor, where a pixel's centre looks
        builder.addLight(pointLight(vec3(-0.5f, 1e-6f, 0.5f), vec3(1.0f)));
        builder.addLight(ceilingLamp(0.0f, 0.0f, 1.0f));
        countBad(run, painter, draw(painter, builder.finish(), lookAt(vec3(0, 2, 2), vec3(0.0f)), {}, 4));
        lampInCeiling(run, painter);
    }
}

void cameraOnSurface(Run& run) {
    // A wall 5 mm before the eye is nearer than the naive tracer's epsilon.
    const World world(panel(vec3(-1, -1, -0.005f), vec3(2, 0, 0), vec3(0, 2, 0)));
    const Ray ray = makeRay(vec3(0.1f, 0.2f, 0), vec3(0, 0, -1));
    std::vector<Met> met;
    naiveTracer(world)->trace(std::span(&ray, 1), met);
    run.rate(column::NAIVE, "walls before the eye not seen", !met[0].hit(), 1, 0.0);
    for (const Painter& painter : painters(run)) {
        for (float wall : {-0.005f, -1e-5f, 0.0f}) {
            SceneBuilder builder = darkness();
            place(builder,
                  panel(vec3(-9, -9, wall), vec3(18, 0, 0), vec3(0, 18, 0), builder.addMaterial(glow(vec3(1, 0, 0)), "near")));
            place(builder,
                  panel(vec3(-9, -9, -1), vec3(18, 0, 0), vec3(0, 18, 0), builder.addMaterial(glow(vec3(0, 1, 0)), "far")));
            const Picture p = draw(painter, builder.finish(), lookAt(vec3(0.1f, 0.2f, 0), vec3(0.1f, 0.2f, -1)));
            uint64_t wrong = 0;
            for (vec4 v : p.pixels) wrong += wall < 0.0f ? v.x != 1.0f : v.y != 1.0f;
            run.rate(painter.column, wall < 0.0f ? "walls before the eye not seen" : "a wall in the eye not looked through",
                     wrong, p.pixels.size(), 0.0);
        }
        SceneBuilder builder = darkness(vec3(0.5f));
        place(builder, box(vec3(-1), vec3(1), builder.addMaterial(glass(1.5f), "glass")));
        const auto scene = builder.finish();
        for (vec3 eye : {vec3(1, 1, 1), vec3(1, 0, 0), vec3(0, 0, 0), vec3(1, 1, 0)})
            countBad(run, painter, draw(painter, scene, lookAt(eye, eye + vec3(-0.7f, -0.4f, -0.5f), 60.0f)));
    }
}

namespace {

/// A lamp whose radiance is no number, which no file can hold: each sample that sees it is left out and counted, and no other.
void injected(Run& run, const Painter& painter) {
    SceneBuilder builder = darkness(vec3(0.5f));
    const uint32_t lamp = builder.addMaterial(glow(vec3(1.0f)), "lamp");
    place(builder, panel(vec3(-0.52f, -0.31f, 0), vec3(1, 0, 0), vec3(0, 0.7f, 0), lamp));
    place(builder, panel(vec3(-3, -3, -2), vec3(6, 0, 0), vec3(0, 6, 0), builder.addMaterial(paint(vec3(0.5f)), "wall")));
    // Behind the camera: a scene of which nothing glows by a number calls for no emission.
    place(builder, panel(vec3(0, 0, 9), vec3(1, 0, 0), vec3(0, 1, 0), builder.addMaterial(glow(vec3(0.1f)), "ember")));
    const auto good = builder.finish();
    const Camera camera = lookAt(vec3(0, 0, 3), vec3(0.0f));
    Settings settings;
    settings.surfaceLights = false;
    const uint32_t samples = 4;
    const Picture clean = draw(painter, good, camera, settings, samples);
    for (float value : {NAN, INFINITY}) {
        const auto broken = std::make_shared<Scene>(*good);
        broken->materials[lamp].emission = vec4(vec3(value), 0.0f);
        broken->contentHash ^= std::bit_cast<uint32_t>(value);
        const Picture bad = draw(painter, broken, camera, settings, samples);
        uint64_t lost = 0, broke = 0, changed = 0;
        for (size_t i = 0; i < bad.pixels.size(); i++) {
            const vec4 p = bad.pixels[i], q = clean.pixels[i];
            broke += !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
            const bool sees = std::fabs(q.x - 1.0f) < 1e-6f;  // all of the lamp
            lost += sees;
            const bool border = q.x != clean.pixels[i > 0 ? i - 1 : i].x;
            changed += !sees && !border && q.x < 0.6f && std::memcmp(&p, &q, sizeof p) != 0;
        }
        run.rate(painter.column, "not finite pixels", broke, bad.pixels.size(), 0.0);
        run.rate(painter.column, "pixels changed that see no such sample", changed, bad.pixels.size(), 0.0);
        // Pixels on the border see it with some of their samples.
        const uint64_t counted = bad.stats.nonfiniteSamples, least = lost * samples, most = least + 400 * samples;
        run.rate(painter.column, "samples that are no numbers and not counted", counted < least ? least - counted : 0, least,
                 0.0);
        run.rate(painter.column, "samples counted that are numbers", counted > most ? counted - most : 0, most, 0.0);
    }
}

}  // namespace

void containment(Run& run) {
    const float light = 3e38f;
    run.note("what a file can hold is clamped; samples that are no numbers were put into a scene by hand");
    run.rate(column::NAIVE, "not finite pixels", !std::isfinite(light + light), 1, 0.0);
    for (const Painter& painter : painters(run)) {
        injected(run, painter);
        const auto scene = [](float glowing) {
            SceneBuilder builder = darkness(vec3(0.5f));
            Material m = mirror(0.9f);
            m.emission = vec4(vec3(glowing), 0.0f);
            const uint32_t bad = builder.addMaterial(m, "too bright");
            place(builder, panel(vec3(-0.2f, 0, -0.2f), vec3(0.4f, 0, 0), vec3(0, 0, -0.4f), bad));
            place(builder, panel(vec3(-2, 1, -2), vec3(4, 0, 0), vec3(0, 0, 4), bad));
            place(builder,
                  panel(vec3(-3, -0.5f, -4), vec3(6, 0, 0), vec3(0, 0, 6), builder.addMaterial(paint(vec3(0.5f)), "floor")));
            return builder.finish();
        };
        Settings settings;
        settings.maxReflections = 4;
        const Camera camera = lookAt(vec3(0, 0.6f, 1.2f), vec3(0, 0, -0.4f), 60.0f);
        const auto tooBright = scene(light);
        for (const std::string& warning : tooBright->warnings) run.note(warning);
        const Picture good = draw(painter, scene(1.0f), camera, settings), bad = draw(painter, tooBright, camera, settings);
        uint64_t broken = 0, lost = 0;
        for (size_t i = 0; i < bad.pixels.size(); i++) {
            const vec4 p = bad.pixels[i];
            broken += !(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
            lost += p.w < 1.0f || (p.x == 0.0f && good.pixels[i].x > 0.0f);
        }
        run.rate(painter.column, "not finite pixels", broken, bad.pixels.size(), 0.0);
        run.rate(painter.column, "samples lost but not counted",
                 lost > bad.stats.nonfiniteSamples ? lost - bad.stats.nonfiniteSamples : 0, bad.pixels.size(), 0.0);
        run.note(std::string(painter.column) + ": " + std::to_string(bad.stats.nonfiniteSamples) +
                 " samples were no numbers, and were counted");
    }
}

void devicesAgree(Run& run) {
    MeshData small = icosphere(3);
    for (vec3& p : small.positions) p *= 0.004f;
    const World world(small);
    std::vector<Ray> rays;
    for (int i = 0; i < 10000; i++)
        rays.push_back(
            makeRay(vec3(0, 0, 0.012f), glm::normalize(vec3(float(i % 100 - 50) * 0.006f, float(i / 100 - 50) * 0.006f, -1))));
    std::vector<Met> a, b;
    naiveTracer(world)->trace(rays, a);
    bareEmbree(world, true)->trace(rays, b);
    uint64_t differ = 0;
    for (size_t i = 0; i < rays.size(); i++) differ += a[i].triangle != b[i].triangle;
    run.rate(column::NAIVE, "pixels off Embree's by 1 %", differ, rays.size(), 5e-4);
    const uvec2 size = run.plan().nightly ? uvec2(640, 360) : uvec2(240, 135);
    for (const char* name : {"cornell", "glass", "courtyard"}) {
        const auto scene = openScene(name);
        const Camera camera = cameraFrom(scene->cameras.front());
        const std::vector<Painter> all = painters(run);
        Settings settings;
        settings.embreeThreads = 1;
        const Picture one = draw(all[0], scene, camera, settings, 1, size);
        settings.embreeThreads = 2;
        const Picture two = draw(all[0], scene, camera, settings, 1, size);
        run.rate(column::EMBREE, "pixels that depend on the number of threads", differing(one, two, 0.0), one.pixels.size(),
                 0.0);
        if (all.size() > 1)
            run.rate(column::VULKAN, "pixels off Embree's by 1 %",
                     differing(one, draw(all[1], scene, camera, settings, 1, size), 0.01), one.pixels.size(), 5e-4);
    }
}

}  // namespace heliograph::hard

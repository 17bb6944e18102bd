// Case 21: bodies in bodies. A glass vessel full of water, with walls that coincide, overlap or leave a gap, against the series of
// all paths through its layers (Fresnel and Beer-Lambert in 113 bits, angles by Snell).

#include "server/scene/load/scene_source.h"
#include "tests/hard/cases.h"
#include "tests/hard/exact.h"
#include "tests/hard/painter.h"

namespace heliograph::hard {

namespace {

using namespace test;

constexpr float GLASS = 1.5f, WATER = 1.33f, WALL = 0.1f, FULL = 0.5f;  // indices; metres along z
constexpr float GLASS_SIGMA = 0.8f, WATER_SIGMA = 0.6f;                 // per metre

/// A stack of layers: what it transmits, and reflects in front and behind.
struct Stack {
    Quad through = 1, front = 0, back = 0;
    Stack then(const Stack& o) const {
        const Quad rounds = 1 / (1 - back * o.front);
        return {through * o.through * rounds, front + through * through * o.front * rounds,
                o.back + o.through * o.through * back * rounds};
    }
};

/// Rays that come from air under the angle of sine `sine`.
struct Optics {
    Quad sine;
    Quad sineIn(Quad n) const { return sine / n; }
    Quad cosineIn(Quad n) const { return squareRoot(1 - sineIn(n) * sineIn(n)); }
    Stack interface(Quad n1, Quad n2) const {
        const Quad c1 = cosineIn(n1), c2 = cosineIn(n2);
        const Quad s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), p = (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2);
        const Quad r = (s * s + p * p) / 2;
        return {1 - r, r, r};
    }
    Stack layer(Quad n, Quad sigma, Quad depth) const {
        return {std::exp(static_cast<double>(-sigma * depth / cosineIn(n))), 0, 0};
    }
    Stack glass() const { return layer(GLASS, GLASS_SIGMA, WALL); }
    Stack water(Quad depth) const { return layer(WATER, WATER_SIGMA, depth); }
    Stack glassToWater(bool gap) const { return gap ? interface(GLASS, 1).then(interface(1, WATER)) : interface(GLASS, WATER); }
    Stack waterToGlass(bool gap) const { return gap ? interface(WATER, 1).then(interface(1, GLASS)) : interface(WATER, GLASS); }
    Stack vessel(bool gap) const {
        return interface(1, GLASS)
            .then(glass())
            .then(glassToWater(gap))
            .then(water(FULL))
            .then(waterToGlass(gap))
            .then(glass())
            .then(interface(GLASS, 1));
    }
    /// How far to the side a ray has come that went straight through to `beyond` metres behind the vessel.
    Quad aside(Quad beyond) const {
        const auto slope = [&](Quad n) { return sineIn(n) / cosineIn(n); };
        return 2 * WALL * slope(GLASS) + FULL * slope(WATER) + beyond * slope(1);
    }
};

Material body(float ior, float sigma) {
    Material m = glass(ior);
    m.absorption = vec4(sigma, sigma, sigma, 0.0f);
    return m;
}

void joinMaterials(MeshData& to, const MeshData& more) {
    const auto base = static_cast<uint32_t>(to.positions.size());
    to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
    to.normals.insert(to.normals.end(), more.normals.begin(), more.normals.end());
    for (uvec3 t : more.indices) to.indices.push_back(t + base);
    to.materials.insert(to.materials.end(), more.materials.begin(), more.materials.end());
    to.uv0.clear();
}

/// The vessel from z = 0 to -0.7, its water `overlap` metres into its walls, or away from them where that is below 0.
void addVessel(SceneBuilder& builder, float overlap) {
    const vec3 low(-1.4f, -1.4f, -WALL - FULL), high(1.4f, 1.4f, -WALL);
    const uint32_t glassy = builder.addMaterial(body(GLASS, GLASS_SIGMA), "glass");
    MeshData wall = box(low - WALL, high + WALL, glassy);
    joinMaterials(wall, insideOut(box(low, high, glassy)));
    place(builder, wall);
    place(builder, box(low - overlap, high + overlap, builder.addMaterial(body(WATER, WATER_SIGMA), "water")));
}

constexpr float BEYOND = 0.3f;  // from the vessel to the wall behind it

/// The wall behind: red where x is below `edge`, else green.
void addWall(SceneBuilder& builder, float edge) {
    const float z = -2.0f * WALL - FULL - BEYOND;
    place(builder, panel(vec3(edge - 4, -4, z), vec3(4, 0, 0), vec3(0, 8, 0), builder.addMaterial(glow(vec3(1, 0, 0)), "red")));
    place(builder, panel(vec3(edge, -4, z), vec3(4, 0, 0), vec3(0, 8, 0), builder.addMaterial(glow(vec3(0, 1, 0)), "green")));
}

/// From the air before the vessel onto its middle.
Camera towards(float degrees) {
    const float turn = glm::radians(degrees);
    return lookAt(vec3(-std::sin(turn), 0, std::cos(turn)), vec3(0.0f), 0.5f);
}

Settings shallow() {
    Settings settings;
    settings.maxReflections = 4;
    settings.maxRefractions = 10;
    return settings;
}

double sum(vec3 colour) { return double(colour.x) + double(colour.y); }
double meanSum(const Picture& picture) {
    double total = 0.0;
    for (vec4 p : picture.pixels) total += sum(vec3(p));
    return total / double(picture.pixels.size());
}

void brightness(Run& run, const Painter& painter, float overlap, float degrees) {
    SceneBuilder builder = darkness();
    addVessel(builder, overlap);
    addWall(builder, 0.0f);
    const auto scene = builder.finish();
    const Optics optics{Quad(std::sin(glm::radians(degrees)))};
    const double exact = static_cast<double>(optics.vessel(overlap < 0.0f).through);
    const char* metric = overlap == 0.0f  ? "off the series, walls that coincide"
                         : overlap > 0.0f ? "off the series, walls that overlap"
                                          : "off the series, a gap of 1e-4";
    const Picture seen = draw(painter, scene, towards(degrees), shallow(), 1, uvec2(1, 1));
    run.most(painter.column, metric, std::fabs(sum(seen.centre()) / exact - 1.0), 1e-2, 1);
    Settings paths = shallow();
    paths.integrator = 1;
    const Picture walked = draw(painter, scene, towards(degrees), paths, 16, uvec2(31, 31));
    run.most(painter.column, std::string(metric) + ", by paths", std::fabs(meanSum(walked) / exact - 1.0), 1e-2, 1);
    const RayCounts& rays = walked.stats.rays;
    run.rate(painter.column, "bodies left unentered, or too many", rays.mediaUnderflows + rays.mediaOverflows,
             rays[RayKind::refraction], 1e-6);
}

/// The edge of the wall stands a little beside where Snell's path lands.
void landing(Run& run, const Painter& painter, float overlap, float degrees) {
    const Optics optics{Quad(std::sin(glm::radians(degrees)))};
    const auto aside = static_cast<float>(static_cast<double>(optics.aside(BEYOND)));
    for (float off : {-1e-3f, 1e-3f}) {
        SceneBuilder builder = darkness();
        addVessel(builder, overlap);
        addWall(builder, aside + off);
        const vec3 seen = draw(painter, builder.finish(), towards(degrees), shallow(), 1, uvec2(1, 1)).centre();
        run.rate(painter.column, "lands more than 1e-3 beside Snell's path", off < 0.0f ? seen.x > seen.y : seen.y > seen.x, 1,
                 0.0);
    }
}

void fromWithin(Run& run, const Painter& painter, float overlap) {
    SceneBuilder builder = darkness();
    addVessel(builder, overlap);
    addWall(builder, 0.0f);
    const Camera camera = lookAt(vec3(0.1f, 0.1f, -WALL - 0.2f), vec3(0.1f, 0.1f, -3), 0.5f);
    const Optics straight{0};
    const Stack ahead = straight.waterToGlass(false).then(straight.glass()).then(straight.interface(GLASS, 1));
    const Quad round = straight.water(FULL).through;
    const double exact = static_cast<double>(straight.water(FULL - 0.2f).through * ahead.through /
                                             (1 - ahead.front * ahead.front * round * round));
    const Picture seen = draw(painter, builder.finish(), camera, shallow(), 1, uvec2(1, 1));
    run.most(painter.column, "off the series, from within the water", std::fabs(sum(seen.centre()) / exact - 1.0), 1e-2, 1);
}

/// A white wall behind the vessel in the sun that shines through it: straight, without what goes back and forth.
void shadow(Run& run, const Painter& painter, float overlap) {
    SceneBuilder builder("test");
    builder.setEnvironmentColor(vec3(0.0f));
    builder.addLight(sun(vec3(0, 0, -1), vec3(float(EXACT_PI))));
    addVessel(builder, overlap);
    const float z = -2.0f * WALL - FULL - BEYOND;
    place(builder, panel(vec3(-1, -1, z), vec3(2, 0, 0), vec3(0, 2, 0), builder.addMaterial(paint(vec3(1.0f)), "white")));
    const Optics o{0};
    const bool gap = overlap < 0.0f;
    const auto once = [](const Stack& a, const Stack& b) { return Stack{a.through * b.through, 0, 0}; };
    Stack exact = once(o.interface(1, GLASS), o.glass());
    if (gap) exact = once(once(exact, o.interface(GLASS, 1)), o.interface(1, WATER));
    else exact = once(exact, o.interface(GLASS, WATER));
    exact = once(exact, o.water(FULL));
    if (gap) exact = once(once(exact, o.interface(WATER, 1)), o.interface(1, GLASS));
    else exact = once(exact, o.interface(WATER, GLASS));
    exact = once(once(exact, o.glass()), o.interface(GLASS, 1));
    const Camera camera = lookAt(vec3(0.3f, 0.2f, z + 0.2f), vec3(0, 0, z), 1.0f);
    const double seen = double(draw(painter, builder.finish(), camera, shallow(), 1, uvec2(1, 1)).centre().x);
    run.most(painter.column, "shadow off Fresnel's and Beer's product",
             std::fabs(seen / static_cast<double>(exact.through) - 1.0), 1e-3, 1);
}

/// A glass with water, ice and a straw, as it is drawn: nobody loses track of where it is.
void stillLife(Run& run) {
    const auto scene = openScene("effects/nested-glass");
    const Camera camera = cameraFrom(scene->cameras.front());
    const uvec2 size = run.plan().nightly ? uvec2(640, 360) : uvec2(160, 90);
    std::vector<Picture> pictures;
    for (const Painter& painter : painters(run)) {
        pictures.push_back(draw(painter, scene, camera, {}, 1, size));
        const RayCounts& rays = pictures.back().stats.rays;
        countBad(run, painter, pictures.back());
        run.rate(painter.column, "bodies left unentered, or too many, in a still life",
                 rays.mediaUnderflows + rays.mediaOverflows, rays[RayKind::refraction], 1e-6);
        run.rate(painter.column, "pixels off Embree's by 1 %", differing(pictures.front(), pictures.back(), 0.01),
                 pictures.front().pixels.size(), 5e-4);
    }
}

}  // namespace

void nestedGlass(Run& run) {
    const float overlaps[] = {0.0f, 1e-3f, 1e-4f, -1e-4f};
    for (float degrees : {0.0f, 20.0f, 45.0f}) {
        // Every surface against air.
        const Optics optics{Quad(std::sin(glm::radians(degrees)))};
        const double naive = static_cast<double>(optics.vessel(true).through),
                     exact = static_cast<double>(optics.vessel(false).through);
        run.most(column::NAIVE, "off the series, walls that coincide", std::fabs(naive / exact - 1.0), 1e-2, 1);
        for (const Painter& painter : painters(run)) {
            for (float overlap : overlaps) brightness(run, painter, overlap, degrees);
            for (float overlap : {0.0f, 1e-4f}) landing(run, painter, overlap, degrees);
        }
    }
    for (const Painter& painter : painters(run)) {
        for (float overlap : {0.0f, 1e-3f}) fromWithin(run, painter, overlap);
        for (float overlap : overlaps) shadow(run, painter, overlap);
    }
    stillLife(run);
}

}  // namespace heliograph::hard

// The kernel on SIMD lanes computes what the scalar kernel computes, bit for bit. Compiled here for the baseline's 4 lanes;
// tests/image/determinism_test.cpp compares whole tiles on all the instruction sets that the processor has.

#define HELIOGRAPH_KERNEL_NAMESPACE lanes_under_test
#include "server/request/effect_rules.h"
#include "server/kernel/kernel_lanes.h"
#include "tests/kernel/kernel_access.h"

#include "server/request/frame_request.h"
#include "server/scene/kernel_tables.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/bodies.h"
#include "tests/support/material_zoo.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
namespace wide = lanes_under_test;
using WideKernel = wide::Kernel<~uint64_t(0)>;
constexpr int LANES = wide::LANES;

uint32_t bitsOf(float x) { return std::bit_cast<uint32_t>(x); }

/// Equal bits, or both not a number.
bool same(wide::Float a, float b, int lane) { return bitsOf(a.v[lane]) == bitsOf(b) || (a.v[lane] != a.v[lane] && b != b); }
bool same(wide::Uint a, uint32_t b, int lane) { return a.v[lane] == b; }
bool same(wide::Bool a, bool b, int lane) { return (a.v[lane] != 0) == b; }
bool same(wide::Vec2 a, vec2 b, int lane) { return same(a.x, b.x, lane) && same(a.y, b.y, lane); }
bool same(wide::Vec3 a, vec3 b, int lane) { return same(a.x, b.x, lane) && same(a.y, b.y, lane) && same(a.z, b.z, lane); }
bool same(wide::Vec4 a, vec4 b, int lane) {
    return same(a.x, b.x, lane) && same(a.y, b.y, lane) && same(a.z, b.z, lane) && same(a.w, b.w, lane);
}

#define EXPECT_FIELD(field) EXPECT_TRUE(same(w.field, s.field, lane)) << #field

void expectSame(const WideKernel::PathState& w, const EveryKernel::PathState& s, int lane) {
    EXPECT_FIELD(origin);
    EXPECT_FIELD(direction);
    EXPECT_FIELD(throughput);
    EXPECT_FIELD(coneWidth);
    EXPECT_FIELD(coneSpread);
    EXPECT_FIELD(depth);
    EXPECT_FIELD(medium);
    EXPECT_FIELD(salt);
}

void expectSame(const WideKernel::Surface& w, const EveryKernel::Surface& s, int lane, uint64_t effects) {
    EXPECT_FIELD(position);
    EXPECT_FIELD(distance);
    EXPECT_FIELD(geometricNormal);
    EXPECT_FIELD(material);
    EXPECT_FIELD(normal);
    EXPECT_FIELD(footprint);
    EXPECT_FIELD(shadowPosition);
    EXPECT_FIELD(side);
    EXPECT_FIELD(edge1);
    EXPECT_FIELD(edge2);
    EXPECT_FIELD(tangentSign);
    if (effects & EFFECT_TEXTURES) {
        EXPECT_FIELD(uv0);
        EXPECT_FIELD(uv1);
        EXPECT_FIELD(uvEdge1);
        EXPECT_FIELD(uvEdge2);
        if (effects & EFFECT_ANISOTROPIC_TEXTURES) {
            EXPECT_FIELD(ellipse.along);
            EXPECT_FIELD(ellipse.across);
        }
    }
    if (effects & EFFECT_VERTEX_COLORS) {
        EXPECT_FIELD(color);
    }
    if (effects & EFFECT_TANGENTS) {
        EXPECT_FIELD(tangent);
    }
}

void expectSameLayers(const WideKernel::Shading& w, const EveryKernel::Shading& s, int lane, EffectSet effects) {
    if (effects.has(EFFECT_ANISOTROPY)) {
        EXPECT_FIELD(tangent);
        EXPECT_FIELD(bitangent);
        EXPECT_FIELD(widthAlong);
        EXPECT_FIELD(widthAcross);
    }
    if (effects.has(EFFECT_IRIDESCENCE)) {
        EXPECT_FIELD(film);
        EXPECT_FIELD(filmThickness);
    }
    if (effects.has(EFFECT_SHEEN)) {
        EXPECT_FIELD(sheen);
        EXPECT_FIELD(sheenAlbedo);
    }
    if (effects.has(EFFECT_CLEARCOAT)) {
        EXPECT_FIELD(coat);
        EXPECT_FIELD(coatRoughness);
        EXPECT_FIELD(coatNormal);
        EXPECT_FIELD(coatAlbedo);
    }
    if (effects.has(EFFECT_DIFFUSE_TRANSMISSION)) {
        EXPECT_FIELD(through);
    }
}

void expectSame(const WideKernel::Shading& w, const EveryKernel::Shading& s, int lane) {
    EXPECT_FIELD(normal);
    EXPECT_FIELD(diffuse);
    EXPECT_FIELD(emission);
    EXPECT_FIELD(f0);
    EXPECT_FIELD(tint);
    EXPECT_FIELD(roughness);
    EXPECT_FIELD(exponent);
    EXPECT_FIELD(alpha);
    EXPECT_FIELD(transmission);
    EXPECT_FIELD(mirror);
    EXPECT_FIELD(occlusion);
    EXPECT_FIELD(ior);
    EXPECT_FIELD(flags);
    EXPECT_FIELD(facet);
}

void expectSame(const WideKernel::ShadowRay& w, const EveryKernel::ShadowRay& s, int lane) {
    EXPECT_FIELD(ray.origin);
    EXPECT_FIELD(ray.direction);
    EXPECT_FIELD(ray.tMax);
    EXPECT_FIELD(contribution);
}

/// A path that meets a random place of a random triangle, from either side.
struct RandomHit {
    EveryKernel::PathState path{};
    Hit hit{};
    uvec2 pixel{};
};

RandomHit randomHit(const Scene& scene, EveryKernel& kernel, Random& random) {
    RandomHit r;
    r.hit.instance = random.below(static_cast<uint32_t>(scene.instances.size()));
    const Instance& instance = scene.instances[r.hit.instance];
    r.hit.primitive = random.below(scene.meshes[instance.mesh].triangleCount);
    const uvec4 corners = scene.triangles[instance.firstTriangle + r.hit.primitive];
    float u = random.real(0.0f, 1.0f), v = random.real(0.0f, 1.0f);
    if (u + v > 1.0f) u = 1.0f - u, v = 1.0f - v;
    vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = kernel.transformPoint(r.hit.instance, vec3(scene.positions[corners[k]]));
    const vec3 target = p[0] * (1.0f - u - v) + p[1] * u + p[2] * v;
    r.path.origin = target + random.direction() * static_cast<float>(random.magnitude(0.01, 100.0));
    r.path.direction = kernel.normalize3(target - r.path.origin);
    r.path.throughput = vec3(random.real(0.0f, 1.0f), random.real(0.0f, 1.0f), random.real(0.0f, 1.0f));
    if (random.below(8) == 0) r.path.throughput = vec3(1e-4f);  // below the threshold: ends here
    r.path.coneWidth = random.real(0.0f, 0.1f);
    r.path.coneSpread = random.real(0.0f, 0.01f);
    r.path.depth =
        random.below(3) | random.below(9) << 8 | random.below(17) << 16 | random.below(2) << 23 | random.below(3) << 24;
    r.path.medium = random.below(3) ? 0u : 1u + random.below(static_cast<uint32_t>(scene.materials.size()));
    r.path.salt = random.word();
    r.pixel = uvec2(random.below(4096), random.below(4096));
    return r;
}

void setLane(wide::Vec3& to, vec3 from, int lane) {
    to.x.v[lane] = from.x;
    to.y.v[lane] = from.y;
    to.z.v[lane] = from.z;
}

/// The whole of a hit and its rays to the lights, in both kernels.
void compareArrivals(EveryKernel& scalar, WideKernel& lanes, const RandomHit (&hits)[LANES], const WideKernel::PathState& path,
                     const wide::HitLanes& hit, wide::Uvec2 pixel, uint32_t sample) {
    wide::Vec3 wideRadiance(vec3(0.5f));
    const WideKernel::Arrival w = lanes.arrive(pixel, sample, path, hit, wideRadiance);
    EXPECT_EQ(lanes.allLightSamples(), scalar.allLightSamples());
    EXPECT_EQ(lanes.fogRays(), scalar.fogRays());
    EveryKernel::Arrival arrivals[LANES];
    for (int lane = 0; lane < LANES; lane++) {
        vec3 radiance(0.5f);
        EveryKernel::Arrival& s = arrivals[lane];
        s = scalar.arrive(hits[lane].pixel, sample, hits[lane].path, hits[lane].hit, radiance);
        EXPECT_TRUE(same(wideRadiance, radiance, lane)) << "radiance";
        EXPECT_FIELD(shading.facet);
        EXPECT_FIELD(wo);
        EXPECT_FIELD(throughput);
        EXPECT_FIELD(ambient);
        EXPECT_FIELD(occlusion);
        EXPECT_FIELD(air);
        EXPECT_EQ(w.next.v[lane], s.next);
#define HAS_LAYER(effect) true
#define COMPARE(bit, path)                                                        \
    if (s.next & EveryKernel::bit) {                                              \
        SCOPED_TRACE(#path " of material " + std::to_string(s.surface.material)); \
        expectSame(w.path, s.path, lane);                                         \
    }
        FOR_NEXT_PATHS(COMPARE)
#undef COMPARE
#undef HAS_LAYER
    }
    for (uint32_t l = 0; l < lanes.allLights(); l++) {
        const uint32_t own = lanes.raysFromSurface(l, 1);
        EXPECT_EQ(own, scalar.raysFromSurface(l, 1));
        for (uint32_t ray = 0; ray < own + lanes.fogRaysTo(l); ray++) {
            SCOPED_TRACE("light " + std::to_string(l) + ", ray " + std::to_string(ray));
            const auto wideRay = lanes.rayToLight(l, ray, own, sample, pixel, path, w);
            for (int lane = 0; lane < LANES; lane++)
                expectSame(wideRay, scalar.rayToLight(l, ray, own, sample, hits[lane].pixel, hits[lane].path, arrivals[lane]),
                           lane);
        }
    }
}

/// All stages of one group of hits, in both kernels.
void compareGroup(EveryKernel& scalar, WideKernel& lanes, const RandomHit (&hits)[LANES], Random& random) {
    WideKernel::PathState path{};
    wide::HitLanes hit{};
    wide::Uvec2 pixel{};
    for (int i = 0; i < LANES; i++) {
        const EveryKernel::PathState& p = hits[i].path;
        setLane(path.origin, p.origin, i);
        setLane(path.direction, p.direction, i);
        setLane(path.throughput, p.throughput, i);
        path.coneWidth.v[i] = p.coneWidth;
        path.coneSpread.v[i] = p.coneSpread;
        path.depth.v[i] = p.depth;
        path.medium.v[i] = p.medium;
        path.salt.v[i] = p.salt;
        path.lobe.v[i] = p.lobe;
        path.way.v[i] = p.way;
        hit.instance.v[i] = hits[i].hit.instance;
        hit.primitive.v[i] = hits[i].hit.primitive;
        pixel.x.v[i] = hits[i].pixel.x;
        pixel.y.v[i] = hits[i].pixel.y;
    }
    const uint32_t sample = random.word() >> 12;
    const uvec2 point = sobolTable()[random.below(EveryKernel::SOBOL_COUNT)];
    const auto wideStart = lanes.startSample(pixel, sample);
    const auto wideSurface = lanes.surfaceAt(path.origin, path.direction, path.coneWidth, path.coneSpread, hit);
    auto wideShading = lanes.shadingAt(wideSurface);
    const wide::Vec3 wideWo = -path.direction;
    lanes.seenFrom(wideShading, wideWo);
    const wide::Vec3 wideThroughput = path.throughput * lanes.mediumTransmittance(path.medium, wideSurface);
    const wide::Vec3 wideEmitted = lanes.emittedRadiance(wideShading, wideThroughput);
    const wide::Vec3 wideAmbient = lanes.ambientContribution(wideShading, wideWo, wideThroughput);
    const wide::Bool wideNeeds = lanes.needsOcclusion(wideAmbient);
    wide::Vec3 wideRadiance = wideEmitted;
    WideKernel::PathState wideNext[3] = {};
    const wide::Uint wideKinds =
        lanes.nextRays(path, wideSurface, wideShading, wideThroughput, wideNext[0], wideNext[1], wideNext[2], wideRadiance);
    const wide::Vec3 wideThrough = lanes.surfaceTransmittance(wideSurface, path.direction);
    const wide::Vec3 wideMiss = lanes.missRadiance(path);
    wide::Vec3 wideTangent, wideBitangent;
    lanes.orthonormalBasis(wideShading.normal, wideTangent, wideBitangent);
    const wide::Uint wideShift = lanes.occlusionShift(pixel, path.salt);
    const wide::Vec3 wideOcclusion = lanes.occlusionDirection(wide::Uvec2(point), wideShift, wideShading.normal,
                                                              wideSurface.geometricNormal, wideTangent, wideBitangent);
    const wide::Bool wideHole = lanes.isCutOut(wideSurface);
    std::vector<WideKernel::ShadowRay> wideShadows;
    for (uint32_t l = 0; l < lanes.frame.lightCount; l++)
        wideShadows.push_back(lanes.lightRay(l, wideSurface, wideShading, wideWo, wideThroughput));

    for (int lane = 0; lane < LANES; lane++) {
        const EveryKernel::PathState& p = hits[lane].path;
        expectSame(wideStart, scalar.startSample(hits[lane].pixel, sample), lane);
        const auto surface = scalar.surfaceAt(p.origin, p.direction, p.coneWidth, p.coneSpread, hits[lane].hit);
        expectSame(wideSurface, surface, lane, scalar.frame.effects);
        SCOPED_TRACE("material " + std::to_string(surface.material));
        auto shading = scalar.shadingAt(surface);
        const vec3 wo = -p.direction;
        scalar.seenFrom(shading, wo);
        expectSame(wideShading, shading, lane);
        expectSameLayers(wideShading, shading, lane, {uint64_t(scalar.frame.layers) << 32});
        const vec3 throughput = p.throughput * scalar.mediumTransmittance(p.medium, surface);
        EXPECT_TRUE(same(wideThroughput, throughput, lane)) << "mediumTransmittance";
        const vec3 emitted = scalar.emittedRadiance(shading, throughput);
        EXPECT_TRUE(same(wideEmitted, emitted, lane)) << "emittedRadiance";
        const vec3 ambient = scalar.ambientContribution(shading, wo, throughput);
        EXPECT_TRUE(same(wideAmbient, ambient, lane)) << "ambientContribution";
        EXPECT_TRUE(same(wideNeeds, scalar.needsOcclusion(ambient), lane)) << "needsOcclusion";
        vec3 radiance = emitted;
        EveryKernel::PathState next[3] = {};
        const uint32_t kinds = scalar.nextRays(p, surface, shading, throughput, next[0], next[1], next[2], radiance);
        EXPECT_EQ(wideKinds.v[lane], kinds);
        EXPECT_TRUE(same(wideRadiance, radiance, lane)) << "nextRays: radiance";
        const uint32_t bits[] = {EveryKernel::NEXT_REFLECTION, EveryKernel::NEXT_REFRACTION, EveryKernel::NEXT_PASS};
        for (int k = 0; k < 3; k++)
            if (kinds & bits[k]) expectSame(wideNext[k], next[k], lane);
        EXPECT_TRUE(same(wideThrough, scalar.surfaceTransmittance(surface, p.direction), lane)) << "surfaceTransmittance";
        EXPECT_TRUE(same(wideMiss, scalar.missRadiance(p), lane)) << "missRadiance";
        vec3 tangent, bitangent;
        scalar.orthonormalBasis(shading.normal, tangent, bitangent);
        const uint32_t shift = scalar.occlusionShift(hits[lane].pixel, p.salt);
        EXPECT_TRUE(same(wideOcclusion,
                         scalar.occlusionDirection(point, shift, shading.normal, surface.geometricNormal, tangent, bitangent),
                         lane))
            << "occlusionDirection";
        EXPECT_TRUE(same(wideHole, scalar.isCutOut(surface), lane)) << "isCutOut";
        for (uint32_t l = 0; l < scalar.frame.lightCount; l++) {
            const auto shadow = scalar.lightRay(l, surface, shading, wo, throughput);
            SCOPED_TRACE("light " + std::to_string(l));
            expectSame(wideShadows[l], shadow, lane);
        }
    }
    compareArrivals(scalar, lanes, hits, path, hit, pixel, sample);
}

/// `effects` by round: all, then random subsets.
void compareScene(const Scene& scene, int groups, uint64_t seed) {
    EveryKernel scalar{};
    WideKernel lanes{};
    Settings settings;
    settings.ambientOcclusion = true;
    FrameRequest request{cameraFrom(scene.cameras[0]), settings, EffectSet{~uint64_t(0)}, uvec2(640, 480), 1};
    request.previousCamera = request.camera;
    request.previousCamera->position += vec3(0.3f, -0.1f, 0.2f);
    scalar.scene = lanes.scene = sceneView(scene);
    scalar.frame = lanes.frame = frameConstants(scene, request);
    const EffectSet sceneEffects = effectsOf(scene);  // those that viewers choose are always among them
    Random random(seed);
    for (int group = 0; group < groups; group++) {
        scalar.frame.effects = lanes.frame.effects = group % 2 ? sceneEffects.low() & random.word() : sceneEffects.low();
        scalar.frame.layers = lanes.frame.layers = group % 2 ? sceneEffects.high() & random.word() : sceneEffects.high();
        RandomHit hits[LANES];
        for (int i = 0; i < LANES; i++) hits[i] = group % 3 == 2 && i > 0 ? hits[i - 1] : randomHit(scene, scalar, random);
        compareGroup(scalar, lanes, hits, random);
        if (testing::Test::HasFailure()) FAIL() << "group " << group << " of " << scene.name;
    }
}

TEST(Lanes, EqualTheScalarKernelInTheMaterialZoo) { compareScene(*test::materialZoo(true), 20000, 1); }

TEST(Lanes, EqualTheScalarKernelInTheCornellBox) { compareScene(*openScene("cornell"), 5000, 2); }

TEST(Lanes, EqualTheScalarKernelInTheCourtyard) { compareScene(*openScene("courtyard"), 5000, 3); }

// The choice of lights, each lane's own; every second scene effect is off by turns.
TEST(Lanes, EqualTheScalarKernelUnderManyLights) { compareScene(*openScene("effects/many-lights"), 3000, 5); }

TEST(Lanes, ChooseAndSeeLightsOfAllKindsAsTheScalarKernelDoes) {
    SceneBuilder builder("lights");
    builder.addInstance(builder.addMesh(panel(vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2), 0)), mat4(1.0f));
    Random random(6);
    for (uint32_t i = 0; i < 120; i++) {
        Light light{};
        light.type = std::array{LIGHT_POINT, LIGHT_SPOT, LIGHT_QUAD}[i % 3];
        light.position = random.inCube(4.0f);
        light.direction = random.direction();
        light.intensity = vec3(random.real(0.1f, 3.0f));
        light.radius = i % 3 != 2 && i % 2 ? 0.3f : 0.0f;
        light.range = i % 5 ? 0.0f : 5.0f;
        light.falloff = i % 7 ? FALLOFF_INVERSE_SQUARE : FALLOFF_LINEAR;
        light.cosInner = 0.9f;
        light.cosOuter = 0.5f;
        light.edge = glm::normalize(glm::cross(light.direction, vec3(0.3f, 0.5f, 0.8f))) * 0.4f;
        light.aspect = 0.5f;
        builder.addLight(light);
    }
    const auto scene = builder.finish();
    EveryKernel scalar = bareKernel();
    WideKernel lanes{};
    scalar.scene = lanes.scene = sceneView(*scene);
    scalar.frame.effects |= EFFECT_MANY_LIGHTS;
    lanes.frame = scalar.frame;
    for (int round = 0; round < 5000; round++) {
        const uint32_t surface = random.below(2);
        EveryKernel::LightWay ways[LANES];
        WideKernel::LightWay way{};
        wide::Float number{};
        wide::Vec2 place{};
        for (int lane = 0; lane < LANES; lane++) {
            ways[lane] = {random.inCube(6.0f), random.direction(), surface ? 0.0f : random.real(0.1f, 5.0f)};
            setLane(way.origin, ways[lane].origin, lane);
            setLane(way.direction, ways[lane].direction, lane);
            way.reach.v[lane] = ways[lane].reach;
            number.v[lane] = random.real(0.0f, 1.0f);
            place.x.v[lane] = random.real(0.0f, 1.0f);
            place.y.v[lane] = random.real(0.0f, 1.0f);
        }
        const auto chosen = lanes.chosenLight(way, surface, number);
        const auto light = lanes.lightOfTree(chosen.light, place, way.origin);
        for (int lane = 0; lane < LANES; lane++) {
            const auto one = scalar.chosenLight(ways[lane], surface, number.v[lane]);
            ASSERT_TRUE(same(chosen.light, one.light, lane) && same(chosen.chance, one.chance, lane));
            if (one.chance == 0.0f) continue;
            const auto seen = scalar.lightOfTree(one.light, vec2(place.x.v[lane], place.y.v[lane]), ways[lane].origin);
            ASSERT_TRUE(same(light.direction, seen.direction, lane) && same(light.distance, seen.distance, lane) &&
                        same(light.irradiance, seen.irradiance, lane));
        }
    }
}

TEST(Lanes, MathematicsIsTheSameForAllFloats) {
    EveryKernel scalar = bareKernel();
    WideKernel lanes{};
    Random random(4);
    for (int i = 0; i < 200000; i++) {
        wide::Float x{}, y{};
        for (int lane = 0; lane < LANES; lane++) {
            x.v[lane] = random.real(-3.0f, 3.0f) * static_cast<float>(random.magnitude(1e-9, 30.0));
            y.v[lane] = random.real(-1.0f, 1.0f);
        }
        wide::Float s, c;
        lanes.sinCosTurn(lanes.saturate(y), s, c);
        const wide::Float values[] = {lanes.expKernel(x),
                                      lanes.logKernel(abs(x)),
                                      lanes.powKernel(abs(y), abs(x)),
                                      s,
                                      c,
                                      lanes.acosKernel(y),
                                      lanes.atan2Kernel(x, y),
                                      lanes.log2Rough(abs(x)),
                                      lanes.wrapCoordinate(x, wide::Uint(uint32_t(WRAP_MIRROR)))};
        for (int lane = 0; lane < LANES; lane++) {
            const float a = x.v[lane], b = y.v[lane];
            float sine, cosine;
            scalar.sinCosTurn(scalar.saturate(b), sine, cosine);
            const float expected[] = {scalar.expKernel(a),
                                      scalar.logKernel(std::abs(a)),
                                      scalar.powKernel(std::abs(b), std::abs(a)),
                                      sine,
                                      cosine,
                                      scalar.acosKernel(b),
                                      scalar.atan2Kernel(a, b),
                                      scalar.log2Rough(std::abs(a)),
                                      scalar.wrapCoordinate(a, WRAP_MIRROR)};
            for (size_t f = 0; f < std::size(expected); f++)
                ASSERT_TRUE(same(values[f], expected[f], lane)) << f << " of " << a << ", " << b;
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

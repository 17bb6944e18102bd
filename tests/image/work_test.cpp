// Work is left out inside an effect, too: what cannot change a pixel gets no ray. Counted, not timed.

#include "tests/image/picture.h"

#include "server/scene/load/scene_source.h"
#include "tests/support/material_zoo.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cstring>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

constexpr uint64_t PIXELS = 97 * 97;
const Camera DOWN = lookAt(vec3(0, 3, 0), vec3(0.0f), 20.0f);

/// The floor seen from above, of `material` and lit by `light`, under an even sky.
std::shared_ptr<const Scene> floorOf(const Material& material, const Light& light, vec3 sky = vec3(0.0f)) {
    SceneBuilder builder("floor");
    builder.setEnvironmentColor(sky);
    place(builder, ground(100.0f, builder.addMaterial(material, "floor")));
    builder.addLight(light);
    return builder.finish();
}

uint64_t raysOf(RayKind kind, const std::shared_ptr<const Scene>& scene, const Settings& settings = {}) {
    return render(scene, DOWN, settings).stats.rays[kind];
}

TEST(WorkLeftOut, NoShadowRayWhereALightDoesNotReach) {
    const Material white = paint(vec3(1.0f));
    Light light = pointLight(vec3(0, 5, 0), vec3(10.0f));
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), PIXELS);
    light.range = 4.9f;
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 0u) << "out of range";
    light.falloff = FALLOFF_LINEAR;
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 0u) << "out of linear range";
    light.range = 0.0f;
    light.type = LIGHT_SPOT;
    light.direction = glm::normalize(vec3(1, -0.2f, 0));
    light.cosInner = std::cos(0.2f);
    light.cosOuter = std::cos(0.4f);
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 0u) << "out of the cone";
    light = pointLight(vec3(0, -5, 0), vec3(10.0f));
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 0u) << "from behind";
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, pointLight(vec3(0, 5, 0), vec3(0.0f)))), 0u) << "a light that is off";
}

TEST(WorkLeftOut, NoShadowRayOutsideTheLightOfAQuadOrASoftSpot) {
    const Material white = paint(vec3(1.0f));
    Light light = pointLight(vec3(0, 5, 0), vec3(10.0f));
    light.radius = 0.3f;
    light.range = 4.5f;
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 0u) << "out of range";
    light.range = 0.0f;
    light.type = LIGHT_SPOT;
    light.direction = vec3(1, 0, 0);
    light.cosInner = 0.99f;
    light.cosOuter = 0.95f;
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 0u) << "out of the cone";
    light.type = LIGHT_QUAD;
    light.direction = vec3(0, 1, 0);
    light.edge = vec3(1, 0, 0);
    light.aspect = 1.0f;
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 0u) << "it shines the other way";
    light.direction = vec3(0, -1, 0);
    EXPECT_EQ(raysOf(RayKind::shadow, floorOf(white, light)), 4u * PIXELS);
}

// A light at the eye reaches whatever the camera's rays meet first; what lies behind a mirror, or is seen through a lens, may be
// in its shadow.
TEST(WorkLeftOut, NoShadowRayToALightAtTheEye) {
    Light light = pointLight(vec3(0.0f), vec3(2.0f));
    light.type = LIGHT_HEADLIGHT;
    const auto floor = floorOf(paint(vec3(1.0f)), light);
    EXPECT_EQ(raysOf(RayKind::shadow, floor), 0u);
    const Picture lit = render(floor, DOWN);
    EXPECT_NEAR(lit.at(48, 48).x, 2.0 / EXACT_PI, 1e-3) << "and yet it shines";
    Settings settings;
    settings.fog = true;
    EXPECT_EQ(raysOf(RayKind::shadow, floor, settings), 0u) << "nor from the fog before it";
    settings.fog = false;
    settings.depthOfField = true;
    settings.aperture = 0.1f;
    EXPECT_EQ(raysOf(RayKind::shadow, floor, settings), PIXELS);
    // Over the head of the camera there is a ceiling, which the floor mirrors.
    SceneBuilder builder("between mirrors");
    builder.setEnvironmentColor(vec3(0.0f));
    place(builder, ground(100.0f, builder.addMaterial(mirror(0.5f), "floor")));
    place(builder, ground(100.0f, builder.addMaterial(paint(vec3(1.0f)), "ceiling")),
          glm::translate(mat4(1.0f), vec3(0, 6, 0)));
    builder.addLight(light);
    const RayCounts rays = render(builder.finish(), DOWN).stats.rays;
    EXPECT_EQ(rays[RayKind::reflection], PIXELS);
    EXPECT_EQ(rays[RayKind::shadow], PIXELS) << "of the ceiling alone";
}

TEST(WorkLeftOut, NoLightOrOcclusionRayOnWhatOnlyGlows) {
    Settings occlusion;
    occlusion.ambientOcclusion = true;
    const Light light = pointLight(vec3(0, 5, 0), vec3(10.0f));
    Material unlit = paint(vec3(1.0f));
    unlit.flags |= MATERIAL_UNLIT;
    for (const Material& material : {glow(vec3(3.0f)), unlit, paint(vec3(0.0f))}) {
        const auto scene = floorOf(material, light, vec3(1.0f));
        EXPECT_EQ(raysOf(RayKind::shadow, scene, occlusion), 0u);
        EXPECT_EQ(raysOf(RayKind::ambientOcclusion, scene, occlusion), 0u);
    }
    EXPECT_EQ(raysOf(RayKind::ambientOcclusion, floorOf(paint(vec3(1.0f)), light, vec3(1.0f)), occlusion), 9u * PIXELS);
    EXPECT_EQ(raysOf(RayKind::ambientOcclusion, floorOf(paint(vec3(1.0f)), light), occlusion), 0u)
        << "there is no ambient light";
    occlusion.aoRadius = 0.0f;
    EXPECT_EQ(raysOf(RayKind::ambientOcclusion, floorOf(paint(vec3(1.0f)), light, vec3(1.0f)), occlusion), 0u) << "of radius 0";
}

TEST(WorkLeftOut, NoReflectionOrRefractionBelowTheThreshold) {
    const Light light = pointLight(vec3(0, 5, 0), vec3(10.0f));
    Settings settings;
    settings.contributionThreshold = 0.03f;
    EXPECT_EQ(raysOf(RayKind::reflection, floorOf(mirror(0.04f), light), settings), PIXELS);
    EXPECT_EQ(raysOf(RayKind::reflection, floorOf(mirror(0.02f), light), settings), 0u);
    Material pane = glass(1.5f);
    pane.flags = 0;
    pane.baseColor = vec4(0.04f, 0.04f, 0.04f, 1.0f);
    EXPECT_EQ(raysOf(RayKind::refraction, floorOf(pane, light), settings), PIXELS);
    pane.baseColor = vec4(0.02f, 0.02f, 0.02f, 1.0f);
    EXPECT_EQ(raysOf(RayKind::refraction, floorOf(pane, light), settings), 0u);
}

TEST(WorkLeftOut, AnEffectThatIsOffShootsNothing) {
    const auto scene = materialZoo();
    const Camera camera = cameraFrom(zooCamera());
    Settings settings;
    settings.shadows = settings.reflections = settings.refractions = false;
    settings.softShadows = settings.glossyReflections = settings.depthOfField = settings.motionBlur = true;
    const RayCounts rays = render(scene, camera, settings).stats.rays;
    // What a blended surface lets straight through goes on as the ray that it was: its kind is the camera's own.
    EXPECT_EQ(rays[RayKind::shadow] + rays[RayKind::ambientOcclusion] + rays[RayKind::reflection], 0u);
}

// Allowed effects that the scene does not call for change no bit and shoot no ray.
TEST(WorkLeftOut, AllowedAndNotCalledForIsTheSameAsForbidden) {
    for (const char* name : {"cornell", "effects/hard-shadows"}) {
        const auto scene = openScene(name);
        const Camera camera = cameraFrom(scene->cameras[0]);
        Settings forbidden;
        forbidden.softShadows = false;
        const Picture with = render(scene, camera, {}, 2), without = render(scene, camera, forbidden, 2);
        EXPECT_EQ(with.stats.rays.by, without.stats.rays.by) << name;
        EXPECT_EQ(std::memcmp(with.pixels.data(), without.pixels.data(), with.pixels.size() * sizeof(vec4)), 0) << name;
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

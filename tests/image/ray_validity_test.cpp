// No camera, transform, light or setting makes a ray that ends the process: what is out of reach shows the surroundings.

#include "tests/image/picture.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <limits>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

Settings everything() {
    Settings settings;
    settings.ambientOcclusion = settings.fog = settings.depthOfField = settings.softShadows = true;
    settings.maxReflections = settings.maxRefractions = 3;
    return settings;
}

/// A box that stands where it was modelled and another one placed by `toWorld`; a mirror, so that paths go on.
std::shared_ptr<const Scene> withPlaced(const mat4& toWorld, vec3 light = vec3(1, 4, 3)) {
    SceneBuilder builder = darkness(vec3(0.5f));
    const uint32_t mesh = builder.addMesh(box(vec3(-1.0f), vec3(1.0f), builder.addMaterial(mirror(0.5f), "mirror")));
    builder.addInstance(mesh, mat4(1.0f));
    builder.addInstance(mesh, toWorld);
    builder.addLight(pointLight(light, vec3(30.0f)));
    return builder.finish();
}

const Camera NEAR = lookAt(vec3(3, 2, 7), vec3(0.0f));

TEST(RayValidity, CamerasAtAnyDistanceGiveAPicture) {
    const auto scene = withPlaced(glm::scale(glm::translate(mat4(1.0f), vec3(2, 0, 0)), vec3(1e-5f)));
    for (bool packets : {true, false}) {
        Settings settings = everything();
        settings.primaryPackets = settings.secondaryPackets = packets;
        for (float distance : {1e5f, 1e10f, 1e14f, 1e18f, 1e19f, 1e30f, 3e38f}) {
            Camera camera;
            camera.position = vec3(0, 0, distance);
            const Picture picture = render(scene, camera, settings, 1, uvec2(16, 16));
            EXPECT_EQ(picture.stats.rays.untraceable > 0, distance > scene->rayReach()) << distance;
        }
    }
}

TEST(RayValidity, TransformsOfAnySizeGiveAPicture) {
    const vec3 scales[] = {vec3(1e-5f),
                           vec3(1e-11f),
                           vec3(1e-13f),
                           vec3(1e-19f),
                           vec3(1e-30f),
                           vec3(1, 1, 1e-19f),
                           vec3(1, 1, 1e-30f),
                           vec3(1, 1, 1e-44f),
                           vec3(1, 1e-13f, 1),
                           vec3(1e-19f, 1, 1e19f),
                           vec3(1e12f),
                           vec3(1e13f),
                           vec3(1e17f),
                           vec3(1e20f),
                           vec3(1, 1, 0),
                           vec3(1e-10f, 1, 1e9f),
                           vec3(1e12f, 1e12f, 1e-20f),
                           vec3(std::numeric_limits<float>::quiet_NaN(), 1, 1)};
    for (vec3 scale : scales) {
        mat4 flat = glm::rotate(mat4(1.0f), 0.7f, vec3(1, 2, 3)) * glm::scale(mat4(1.0f), scale) *
                    glm::rotate(mat4(1.0f), 0.4f, vec3(3, 1, 0));
        for (const mat4& toWorld :
             {glm::scale(mat4(1.0f), scale), glm::scale(glm::translate(mat4(1.0f), vec3(4, 0, 1)), scale), flat}) {
            const auto scene = withPlaced(toWorld);
            const Picture picture = render(scene, NEAR, everything(), 1, uvec2(16, 16));
            EXPECT_EQ(picture.stats.rays.untraceable, 0u) << scale.x << " " << scale.y << " " << scale.z;
            render(scene, cameraFrom(scene->cameras.front()), everything(), 1, uvec2(16, 16));
        }
    }
}

TEST(RayValidity, LightsAtAnyDistanceGiveAPicture) {
    for (float distance : {1e6f, 1e15f, 1e18f, 1e19f, 1e30f, 3e38f}) {
        const Picture picture =
            render(withPlaced(glm::translate(mat4(1.0f), vec3(3, 0, 0)), vec3(distance)), NEAR, everything(), 1, uvec2(16, 16));
        EXPECT_EQ(picture.stats.nonfiniteSamples, 0u) << distance;
        EXPECT_EQ(picture.stats.rays.untraceable, 0u) << distance;
    }
}

TEST(RayValidity, ExtremeSettingsGiveAPicture) {
    const auto scene = withPlaced(glm::scale(glm::translate(mat4(1.0f), vec3(2, 0, 0)), vec3(1e-5f)));
    Settings settings = everything();
    settings.aperture = 100.0f;
    settings.fogDensity = 1000.0f;
    settings.aoRadius = 1000.0f;
    for (float focus : {0.0f, 1e-3f, 1e6f}) {
        settings.focusDistance = focus;
        for (float fieldOfView : {0.01f, 179.0f}) {
            Camera camera = NEAR;
            camera.fieldOfView = fieldOfView;
            const Picture picture = render(scene, camera, settings, 2, uvec2(16, 16));
            EXPECT_EQ(picture.stats.rays.untraceable, 0u) << focus << " " << fieldOfView;
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

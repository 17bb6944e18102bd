#pragma once
// Small pictures of small scenes on the CPU device, and where a ray of the camera goes, in double: what image tests compare.

#include "server/device/embree/embree_device.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/bodies.h"
#include "tests/support/random.h"

#include <cmath>
#include <stdexcept>

namespace heliograph::test {

using glm::dvec2;
using glm::dvec3;

struct Picture {
    uvec2 size{0, 0};
    std::vector<vec4> pixels;  // mean radiance, number of samples in w
    FrameStats stats;

    vec3 at(uint32_t x, uint32_t y) const { return vec3(pixels[size_t(y) * size.x + x]); }
    vec3 centre() const { return at(size.x / 2, size.y / 2); }
};

inline Device& cpu() {
    static const std::unique_ptr<Device> device = makeEmbreeDevice();
    return *device;
}

/// Odd sizes have a pixel whose centre is the picture's.
inline Picture render(const std::shared_ptr<const Scene>& scene, const Camera& camera, const Settings& settings = {},
                      uint32_t samples = 1, uvec2 size = uvec2(97, 97)) {
    cpu().load(scene, settings, {});
    Film film;
    Picture picture;
    picture.size = size;
    picture.stats = renderFrame(cpu(), frameRequest(*scene, camera, settings, size, 1), samples, film);
    if (picture.stats.samples != samples) throw std::logic_error("the frame ended early");
    film.develop(picture.pixels);
    return picture;
}

/// Looks from `position` to `target`.
inline Camera lookAt(vec3 position, vec3 target, float fieldOfView = 40.0f) {
    Camera camera;
    camera.position = position;
    camera.forward = target - position;
    camera.up = std::abs(glm::normalize(camera.forward).y) > 0.99f ? vec3(0, 0, -1) : vec3(0, 1, 0);
    camera.fieldOfView = fieldOfView;
    return checkedCamera(camera);
}

/// Unit direction through the centre of pixel (x, y), where the first sample goes.
inline dvec3 rayThrough(const Camera& camera, uvec2 size, uint32_t x, uint32_t y) {
    const dvec3 forward = glm::normalize(dvec3(camera.forward));
    const dvec3 right = glm::normalize(glm::cross(forward, dvec3(camera.up)));
    const dvec3 up = glm::cross(right, forward);
    const double half = std::tan(0.5 * camera.fieldOfView * EXACT_PI / 180.0);
    return glm::normalize(forward + right * (half * (2.0 * (x + 0.5) / size.x - 1.0) * size.x / size.y) +
                          up * (half * (1.0 - 2.0 * (y + 0.5) / size.y)));
}

/// Where the pixel's ray meets the plane through `point` with normal `normal`.
inline dvec3 onPlane(const Camera& camera, uvec2 size, uint32_t x, uint32_t y, dvec3 point, dvec3 normal) {
    const dvec3 d = rayThrough(camera, size, x, y), o(camera.position);
    return o + d * (glm::dot(point - o, normal) / glm::dot(d, normal));
}

/// Distance to the unit sphere at the origin, negative if it is missed.
inline double meetsUnitSphere(dvec3 origin, dvec3 direction) {
    const double b = glm::dot(origin, direction), c = glm::dot(origin, origin) - 1.0;
    return b * b < c ? -1.0 : -b - std::sqrt(b * b - c);
}

// ---- scenes ----

/// No light, no sky: what is bright was put there. (A scene without lights would be given one.)
inline SceneBuilder darkness(vec3 sky = vec3(0.0f)) {
    SceneBuilder builder("test");
    Light none{};
    none.type = LIGHT_DIRECTIONAL;
    none.direction = vec3(0, -1, 0);
    builder.addLight(none);
    builder.setEnvironmentColor(sky);
    return builder;
}

inline void place(SceneBuilder& builder, MeshData mesh, const mat4& toWorld = mat4(1.0f)) {
    builder.addInstance(builder.addMesh(std::move(mesh)), toWorld);
}

/// Diffuse only.
inline Material paint(vec3 color) {
    Material m = SceneBuilder::defaultMaterial();
    m.flags = MATERIAL_PHONG;
    m.specular = vec4(0.0f);
    m.baseColor = vec4(color, 1.0f);
    return m;
}

/// Reflects `reflectance` like a mirror and nothing else.
inline Material mirror(float reflectance) {
    Material m = paint(vec3(0.0f));
    m.mirror = reflectance;
    return m;
}

/// Shows `radiance`, whatever the light.
inline Material glow(vec3 radiance) {
    Material m = paint(vec3(0.0f));
    m.emission = vec4(radiance, 0.0f);
    return m;
}

/// A clear solid body.
inline Material glass(float ior) {
    Material m = SceneBuilder::defaultMaterial();
    m.flags = MATERIAL_VOLUME;
    m.transmission = 1.0f;
    m.roughness = 0.0f;
    m.ior = ior;
    return m;
}

inline Light pointLight(vec3 position, vec3 intensity) {
    Light light{};
    light.type = LIGHT_POINT;
    light.position = position;
    light.direction = vec3(0, -1, 0);
    light.intensity = intensity;
    return light;
}

inline Light sun(vec3 direction, vec3 irradiance) {
    Light light{};
    light.type = LIGHT_DIRECTIONAL;
    light.direction = direction;
    light.intensity = irradiance;
    return light;
}

/// The plane y = `height` from -`half` to `half`, facing up.
inline MeshData ground(float half, uint32_t material, float height = 0.0f) {
    return panel(vec3(-half, height, half), vec3(2 * half, 0, 0), vec3(0, 0, -2 * half), material);
}

}  // namespace heliograph::test

#include "server/scene/light/studio.h"

#include "server/scene/build/default_camera.h"
#include "server/scene/light/environment_tables.h"

#include <cmath>

namespace heliograph {

namespace {

constexpr uint32_t WIDTH = 256, HEIGHT = 128;
/// What white that faces the default camera sends back: with the 0.04 that the neutral curve takes away again, base colours of
/// surfaces of middling roughness then come out as they are.
constexpr float WHITE = 1.04f;

/// 0 below `low`, 1 above `high`, smooth between.
float smoothStep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

/// A rectangle that shines, seen from the middle: where its middle stands, and half its angles across and up.
struct SoftBox {
    float azimuth, elevation;     // degrees; 0 is behind the default camera's model, 180 on the camera's side
    float halfWidth, halfHeight;  // tangents of half the angles
    float radiance;
};

vec3 towards(float azimuth, float elevation) {
    const float a = glm::radians(azimuth), e = glm::radians(elevation);
    return vec3(std::sin(a) * std::cos(e), std::sin(e), -std::cos(a) * std::cos(e));
}

/// What the box adds in direction d; its edge is soft, so that mirrors show no stairs.
float shining(const SoftBox& box, vec3 d) {
    const vec3 middle = towards(box.azimuth, box.elevation);
    const float along = glm::dot(d, middle);
    if (along <= 0.0f) return 0.0f;
    const vec3 right = glm::normalize(glm::cross(middle, vec3(0.0f, 1.0f, 0.0f)));
    const vec3 up = glm::cross(right, middle);
    const float x = std::abs(glm::dot(d, right) / along) / box.halfWidth;
    const float y = std::abs(glm::dot(d, up) / along) / box.halfHeight;
    return box.radiance * (1.0f - smoothStep(0.85f, 1.0f, x)) * (1.0f - smoothStep(0.85f, 1.0f, y));
}

float studioRadiance(vec3 d) {
    static constexpr SoftBox BOXES[] = {
        {115.0f, 36.0f, 0.60f, 0.45f, 5.0f},   // key, on its right and above; flat things mirror none of it to the camera
        {-130.0f, 14.0f, 0.34f, 0.75f, 3.0f},  // fill, tall, on its left
        {-25.0f, 35.0f, 0.90f, 0.16f, 2.0f},   // a strip behind it, for the outline
        {70.0f, 8.0f, 0.16f, 0.60f, 1.6f},     // a narrow one at the side
    };
    float radiance = 0.62f + 0.12f * smoothStep(-0.6f, 0.7f, d.y);  // walls that the boxes light
    for (const SoftBox& box : BOXES) radiance += shining(box, d);
    return radiance;
}

vec3 dayRadiance(vec3 d) {
    const vec3 toSun = towards(140.0f, 48.0f);
    const float up = std::max(d.y, 0.0f), sun = std::max(glm::dot(d, toSun), 0.0f);
    vec3 sky = glm::mix(vec3(0.26f, 0.48f, 0.95f), vec3(0.85f, 0.95f, 1.05f), std::pow(1.0f - up, 4.0f));
    sky += vec3(1.0f, 0.93f, 0.8f) *
           (0.35f * std::pow(sun, 8.0f) + 2.0f * std::pow(sun, 200.0f) + 1500.0f * std::pow(sun, 6000.0f));
    return glm::mix(sky, vec3(0.22f, 0.21f, 0.16f), smoothStep(0.01f, -0.03f, d.y));
}

template <typename Radiance>
ImageData painted(const char* name, Radiance radiance) {
    ImageData image{.width = WIDTH, .height = HEIGHT, .srgb = false, .rgba8 = {}, .rgb32f = {}, .name = name};
    image.rgb32f.reserve(size_t(WIDTH) * HEIGHT * 3);
    const RadianceMap map{WIDTH, HEIGHT, {}};
    for (uint32_t y = 0; y < HEIGHT; y++) {
        for (uint32_t x = 0; x < WIDTH; x++) {
            const vec3 value(radiance(map.direction(x, y)));
            for (int c = 0; c < 3; c++) image.rgb32f.push_back(value[c]);
        }
    }
    return image;
}

}  // namespace

ImageData paintStudio() {
    ImageData image = painted("studio", studioRadiance);
    const RadianceMap map = radianceMap(image, uint64_t(WIDTH) * HEIGHT);
    const float white = irradianceTowards(map, vec3(DEFAULT_VIEW)).x;
    for (float& value : image.rgb32f) value *= WHITE / white;
    return image;
}

ImageData paintClearDay() { return painted("clear day", dayRadiance); }

}  // namespace heliograph

#include "server/scene/generate/sky.h"

#include "server/scene/generate/noise.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace heliograph::generate {

namespace {

vec3 skyRadiance(const SkyLook& look, vec3 d, vec2 uv) {
    const float up = std::max(d.y, 0.0f);
    const float low = std::pow(1.0f - up, 3.5f);
    vec3 sky = glm::mix(look.zenith, look.horizon, low);
    const float toSun = glm::dot(d, look.toSun), towards = std::max(toSun, 0.0f);
    sky += look.glow *
           (0.25f * std::pow(towards, 6.0f) + 0.9f * std::pow(towards, 60.0f) + 3.0f * std::pow(towards, 900.0f));
    if (d.y > 0.01f && look.clouds > 0.0f) {
        // Cirrus: a flat layer of clouds far above, stretched along x. Faded out towards the horizon, where it would
        // alias.
        const vec2 layer = vec2(d.x, 0.6f * d.z) / (d.y + 0.12f);
        const float shape =
            fractalNoise(layer * 1.3f + 32.0f + 0.6f * fractalNoise(layer * 2.0f + 40.0f, 4096, 3, look.seed + 9), 4096,
                         6, look.seed);
        const float cover =
            stepBetween(0.78f - 0.5f * look.clouds, 1.02f - 0.5f * look.clouds, shape) * stepBetween(0.02f, 0.25f, d.y);
        sky = glm::mix(sky, look.cloud * (0.75f + 0.5f * std::pow(towards, 4.0f)), 0.75f * cover);
    }
    const float below = stepBetween(0.004f, -0.016f, d.y);
    const float mottle = 0.9f + 0.2f * valueNoise(uv * 64.0f, 64, look.seed);
    return glm::mix(sky, look.ground * mottle, below);
}

}  // namespace

ImageData paintSky(const SkyLook& look) {
    const uint32_t width = 768, height = 384;
    ImageData image{.width = width, .height = height, .srgb = false, .name = "sky"};
    image.rgb32f.resize(size_t(width) * height * 3);
    tbb::parallel_for(0u, height, [&](uint32_t y) {
        const float v = (float(y) + 0.5f) / float(height), polar = 3.14159265f * v;
        for (uint32_t x = 0; x < width; ++x) {
            const float u = (float(x) + 0.5f) / float(width), azimuth = (u - 0.5f) * 2.0f * 3.14159265f;
            const vec3 d(std::sin(azimuth) * std::sin(polar), std::cos(polar), -std::cos(azimuth) * std::sin(polar));
            const vec3 radiance = skyRadiance(look, d, vec2(u, v));
            float* texel = &image.rgb32f[(size_t(y) * width + x) * 3];
            for (int c = 0; c < 3; ++c) texel[c] = radiance[c];
        }
    });
    return image;
}

vec3 directionOf(float elevation, float azimuth) {
    const float e = glm::radians(elevation), a = glm::radians(azimuth);
    return vec3(std::sin(a) * std::cos(e), std::sin(e), -std::cos(a) * std::cos(e));
}

Light sunLight(vec3 toSun, vec3 irradiance) {
    Light light{};
    light.type = LIGHT_DIRECTIONAL;
    light.direction = -toSun;
    light.intensity = irradiance;
    return light;
}

Light pointLight(vec3 position, vec3 intensity) {
    Light light{};
    light.type = LIGHT_POINT;
    light.position = position;
    light.intensity = intensity;
    light.falloff = FALLOFF_INVERSE_SQUARE;
    return light;
}

Light ballLight(vec3 position, float radius, vec3 intensity) {
    Light light = pointLight(position, intensity);
    light.radius = radius;
    return light;
}

Light quadLight(vec3 center, vec3 target, vec2 halfSize, vec3 intensity) {
    Light light = pointLight(center, intensity);
    light.type = LIGHT_QUAD;
    light.direction = glm::normalize(target - center);
    light.edge = glm::normalize(glm::cross(light.direction, vec3(0, 1, 0))) * halfSize.x;
    light.aspect = halfSize.y / halfSize.x;
    return light;
}

}  // namespace heliograph::generate

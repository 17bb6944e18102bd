#pragma once
// A lat-long sky painted by formula: gradient from horizon to zenith, a glow about the sun, thin clouds, and ground
// below.

#include "server/scene/build/scene_builder.h"

namespace heliograph::generate {

struct SkyLook {
    vec3 toSun{0.5f, 0.7f, 0.5f};        // unit
    vec3 zenith{0.10f, 0.22f, 0.50f};    // radiance
    vec3 horizon{0.55f, 0.60f, 0.66f};
    vec3 glow{1.0f, 0.65f, 0.35f};       // radiance added next to the sun
    vec3 ground{0.20f, 0.17f, 0.13f};
    vec3 cloud{1.0f, 0.95f, 0.88f};      // radiance of a lit cloud
    float clouds = 0.4f;                 // share of the sky, 0..1
    uint32_t seed = 1;
};

/// 768 x 384 pixels; the kernel's orientation: the middle column looks along -Z, the first row is +Y.
ImageData paintSky(const SkyLook& look);
/// The directional light that belongs to a sun: `toSun` unit, `irradiance` on a surface that faces it.
Light sunLight(vec3 toSun, vec3 irradiance);
/// Unit vector to the sun from elevation and azimuth (degrees; azimuth 0 = -Z, 90 = +X).
vec3 directionOf(float elevation, float azimuth);
Light pointLight(vec3 position, vec3 intensity);
/// A ball that shines; from afar as a point light of that intensity.
Light ballLight(vec3 position, float radius, vec3 intensity);
/// A rectangle that shines towards `target` (not straight up or down): half its width, which is level, and half its height.
Light quadLight(vec3 center, vec3 target, vec2 halfSize, vec3 intensity);

}  // namespace heliograph::generate

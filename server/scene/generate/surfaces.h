#pragma once
// Images of building materials, painted by formula: colour and the normal map that belongs to it. All tile.

#include "server/scene/build/scene_builder.h"

#include <functional>
#include <string>

namespace heliograph::generate {

/// One point of a surface.
struct SurfacePoint {
    vec3 color{0.5f};      // sRGB-coded, 0..1
    float height = 0.0f;   // metres
};

struct SurfaceImages {
    ImageData color;
    ImageData normal;      // tangent space, glTF's convention
    float metres = 1.0f;   // after which the image repeats
};

/// Paints size x size pixels. `paint` gets uv in [0, 1)^2; v = 0 is the image's first row. It must be periodic.
SurfaceImages paintSurface(const std::string& name, uint32_t size, float metres,
                           const std::function<SurfacePoint(vec2)>& paint);

SurfaceImages paintLimestone(const std::string& name, vec3 color, uint32_t seed);
/// Rows of cut blocks, two metres of them.
SurfaceImages paintAshlar(const std::string& name, vec3 color, uint32_t seed);
SurfaceImages paintBrick(const std::string& name, uint32_t seed);
SurfaceImages paintPlaster(const std::string& name, vec3 color, uint32_t seed);
/// Square slabs with small insets where four of them meet.
SurfaceImages paintPavers(const std::string& name, uint32_t seed);
/// Terracotta squares laid on edge.
SurfaceImages paintTerracottaFloor(const std::string& name, uint32_t seed);
SurfaceImages paintTerracotta(const std::string& name, uint32_t seed);
SurfaceImages paintWood(const std::string& name, vec3 color, uint32_t seed);
/// Light and dark squares of veined marble, four squares a side.
SurfaceImages paintMarbleChequer(const std::string& name, vec3 light, vec3 dark, uint32_t seed);
/// Heavy cloth with a woven diaper pattern in the second colour.
SurfaceImages paintCloth(const std::string& name, vec3 color, vec3 pattern, uint32_t seed);
/// Small waves on water.
SurfaceImages paintRipples(const std::string& name, uint32_t seed);
/// Leaded panes for a lancet window; `palette` picks the glass. Not square: width x 2 width.
ImageData paintStainedGlass(const std::string& name, uint32_t width, int palette, uint32_t seed);

/// Adds the images and a material that uses them; `base` gives everything else. Coordinates are taken as metres.
uint32_t addSurfaceMaterial(SceneBuilder& builder, const SurfaceImages& images, Material base, const std::string& name,
                            float normalScale = 1.0f);
/// A rough dielectric of one colour (linear).
Material matte(vec3 color, float roughness);

}  // namespace heliograph::generate

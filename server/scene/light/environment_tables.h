#pragma once
// What an environment image needs beyond nine coefficients: levels blurred by the lobes of rough surfaces, its irradiance,
// and a table by which its bright places are chosen as lights. Private to server/scene.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// Radiance of a lat-long image in the direction order of the kernel (row 0 is up), rotation and intensity left out.
struct RadianceMap {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<vec3> texels;
    /// Steradians of a texel of row y.
    double solidAngle(uint32_t y) const;
    /// Unit direction of the middle of a texel.
    vec3 direction(uint32_t x, uint32_t y) const;
};

/// The image in linear light, halved (solid angle weighs) until it has at most `mostTexels`.
RadianceMap radianceMap(const ImageData& image, uint64_t mostTexels);
/// The map halved until it has at most `mostTexels`.
RadianceMap halvedTo(RadianceMap map, uint64_t mostTexels);

/// Irradiance / pi on a surface with that normal: the sum over the texels.
vec3 irradianceTowards(const RadianceMap& map, vec3 normal);
/// The largest relative error of nine coefficients (Environment::ambient without rotation) over 26 directions; of what is
/// at least a tenth of the mean.
double ambientMisses(const RadianceMap& map, const Environment& unrotated);
/// Root mean square error of nine coefficients as what a surface of roughness 0.4 reflects, over the mean.
double reflectionMisses(const RadianceMap& map, const Environment& unrotated);
/// Share of the light that comes from places 20 times as bright as the mean: 0 for a cloudy sky, most of it for a sun.
double concentrated(const RadianceMap& map);

/// The image's FILTERED_LEVELS levels and its irradiance as an image of the scene; its index.
uint32_t appendFiltered(Scene& scene, const RadianceMap& map);
/// The table of Environment::lightTable at the end of the scene's texels; fills in the environment's fields.
void appendLightTable(Scene& scene, Environment& environment, const RadianceMap& map);

}  // namespace heliograph

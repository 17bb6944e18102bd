#pragma once
// Glowing surfaces as lights: which triangles are lamps, and a table by which they are chosen. Private to server/scene.

#include "server/scene/scene.h"

namespace heliograph {

/// Writes the table of Environment::emitterTable behind the scene's texels, for the placed triangles whose material glows
/// (unlit ones, those with alpha and those that a light of its own stands for are none), and the density of its points into the materials'
/// emission.w; more than MOST_LISTED_LAMPS get a tree as well. Returns the mean irradiance of the lamps over the scene's bounding sphere.
float appendEmitters(Scene& scene);

}  // namespace heliograph

#pragma once
// What rough glass of single scattering loses. Private to server/scene.

#include "server/scene/scene.h"

#include <vector>

namespace heliograph {

/// The shares of even light that solid glass and then thin panes reflect and let through, by index of refraction, roughness and
/// cosine: nodes of shaders/kernel/effects/rough_glass.glsl. Quadrature over visible facets, once a process.
const std::vector<float>& glassTable();

/// Puts the table behind the scene's texels where a material is rough glass, and tells Environment::glassTable.
void appendGlassTable(Scene& scene);

}  // namespace heliograph

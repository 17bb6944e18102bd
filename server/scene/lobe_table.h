#pragma once
// What rough lobes reflect of even light. Private to server/scene.

#include "server/kernel/kernel_types.h"

#include <vector>

namespace heliograph {

/// Nodes of kernel/microfacet.glsl's lobe table, two floats each as words: what a GGX lobe of single scattering reflects of
/// even light, as f0 * x + f90 * y. Rows by roughness; quadrature over visible facets.
std::vector<uvec2> lobeTable();

}  // namespace heliograph

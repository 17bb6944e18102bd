#pragma once
// Tables that every device hands to the kernel, computed once on the host.

#include "server/scene/scene.h"
#include "server/kernel/scene_view.h"

namespace heliograph {

/// Points of kernel/sampling.glsl's table: the (0,2)-sequence of Sobol (1967) in two dimensions, Owen-scrambled once by
/// hashing (Laine & Karras, "Stratified Sampling for Stochastic Transparency", 2011; constants by Burley, "Practical
/// Hash-based Owen Scrambling", JCGT 9(4) 2020). 32-bit fixed point in [0, 1).
const std::vector<uvec2>& sobolTable();

/// The points, then the lobes: what the kernel reads as SOBOL.
const std::vector<uvec2>& kernelTable();

/// The scene and the tables as the kernel sees them; valid as long as the scene.
SceneView sceneView(const Scene& scene);

}  // namespace heliograph

#pragma once
// The benchmark's scene: 28 fluted columns under a barrel vault, 34 spheres between them, a ground; 907,000 triangles.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// `detail`: 1 = all triangles; less for machines without a GPU.
std::shared_ptr<const Scene> makeColonnade(float detail);

}  // namespace heliograph

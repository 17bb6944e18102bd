#pragma once
// The smooth light of an environment. Private to server/scene.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// Fills environment.color (mean radiance) and environment.ambient for a lat-long image. Each texel counts with its
/// exact solid angle; sums are in double. Ramamoorthi & Hanrahan, "An Efficient Representation for Irradiance
/// Environment Maps" (2001). Uses environment.intensity and environment.rotation.
void ambientFromImage(Environment& environment, const ImageData& image);

/// The same for one colour from everywhere.
void ambientFromColor(Environment& environment, vec3 radiance);

}  // namespace heliograph

#pragma once
// Small scenes for tests, made through SceneBuilder like all others.

#include "server/scene/build/scene_builder.h"

#include <functional>

namespace heliograph::test {

/// A square of two triangles in the plane z = 0, side 2, centre 0, facing +z, all of `material`.
MeshData square(uint32_t material = 0);

/// One square with what `change` makes of the default material, named `name`, a directional light, no camera path.
std::shared_ptr<const Scene> squareScene(const std::function<void(Material&)>& change = {}, const std::string& name = "paint");

/// A builder that holds nothing but a directional light along -z.
SceneBuilder litBuilder(const std::string& name = "test");

}  // namespace heliograph::test

#pragma once
// The views of a scene that benchmarks of many views look at.

#include "server/app/scene_options.h"

namespace heliograph {

struct NamedView {
    std::string name;
    Camera camera;
};

/// At most so many: the scene's cameras first, then places along its first path.
std::vector<NamedView> viewsOf(const Scene& scene, size_t most, GivenSettings given);

}  // namespace heliograph

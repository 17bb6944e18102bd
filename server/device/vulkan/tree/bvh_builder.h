#pragma once
// Builds a scene's trees: the root tree over all triangles that stand where they were modelled and over the boxes of placed
// instances, and one tree for each mesh that is placed.

#include "server/base/progress.h"
#include "server/device/vulkan/tree/bvh_layout.h"
#include "server/scene/scene.h"

namespace heliograph {

struct BvhOptions {
    uint32_t width = 2;    // 2: float boxes, for GPUs; 4: boxes of 8 bits an axis, for CPU-type devices
    uint32_t maxLeaf = 3;  // triangles
    uint32_t quality = 1;  // 0 low (Morton codes), 1 medium and 2 high (binned surface area heuristic)
};

/// Throws InputError for a scene of more triangles than references can name, std::runtime_error when Embree refuses.
Bvh buildBvh(const Scene& scene, const BvhOptions& options, const Progress& progress = {});

}  // namespace heliograph

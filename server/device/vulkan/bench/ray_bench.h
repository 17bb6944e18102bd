#pragma once
// Bare tracing of given rays on a GPU, by our tracer and by the driver's own ray tracing pipeline. For benchmarks.

#include "server/device/vulkan/trace/trace_pipelines.h"

namespace heliograph {

/// What a ray met: `primitive` of the instance's mesh; any-hit rays only know `found` (1 = blocked).
struct RayAnswer {
    uint32_t instance;
    uint32_t primitive;
    uint32_t found;
    uint32_t pad;
};

class RayBench {
public:
    virtual ~RayBench() = default;
    /// Traces the rays `repetitions` times after `warmUpSeconds` of the same work. anyHit: stop at the first hit. Returns
    /// the GPU's seconds of each repetition, in order.
    virtual std::vector<double> trace(std::span<const Ray> rays, bool anyHit, uint32_t repetitions, double warmUpSeconds,
                                      std::vector<RayAnswer>& answers) = 0;
};

std::unique_ptr<RayBench> makeTracerBench(Gpu& gpu, const GpuScene& scene);
/// Of a scene whose instances all stand where they were modelled; the primitive counts through all of its triangles. Needs
/// GpuFeatures::rayTracingPipeline. Sets `buildSeconds` to the GPU's time for the acceleration structure.
std::unique_ptr<RayBench> makeAnchorBench(Gpu& gpu, const Scene& scene, double& buildSeconds);

}  // namespace heliograph

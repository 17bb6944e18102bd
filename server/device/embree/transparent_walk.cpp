#include "server/device/embree/embree_scene.h"
#include "server/device/embree/tile_job.h"
#include "server/kernel/kernel.h"

#include <new>

namespace heliograph {

void throwNoMemory() { throw std::bad_alloc(); }

vec3 transparentTransmittance(const TileJob& job, vec3 origin, vec3 direction, float tMax, uint32_t media, uint64_t& rays) {
    using KernelType = scalar_kernel::Kernel<~uint64_t(0)>;
    KernelType kernel;
    kernel.scene = *job.view;
    kernel.frame = *job.frame;
    vec3 from = origin;
    float left = tMax;
    vec3 through(1.0f);
    for (uint32_t step = 0; step < KernelType::MAX_SHADOW_SURFACES; step++) {
        RTCRayHit16 packet;
        for (uint32_t i = 0; i < 4; i++) setRay(packet.ray, i, from, direction, left, MASK_TRANSPARENT);  // read by fours
        traceClosest(job.rtcScene, packet, 1, {1, false});
        rays++;
        Hit hit = EmbreeScene::hitOf(packet.hit.geomID[0], packet.hit.primID[0], packet.hit.instID[0][0]);
        if (hit.instance == NO_INDEX) return through * kernel.mediaToLight(media, left);
        auto surface = kernel.surfaceAt(from, direction, 0.0f, 0.0f, hit);
        through = through * kernel.mediaThrough(surface, direction, media);
        if (!(kernel.maxComponent(through) > 0.0f)) return vec3(0.0f);
        left -= surface.distance;
        if (!(left > 0.0f)) return through;
        from = kernel.offsetRayOrigin(surface.position, -surface.geometricNormal, surface.clearance);
    }
    return vec3(0.0f);
}

}  // namespace heliograph

#include "server/device/embree/embree_scene.h"
#include "server/device/embree/tile_job.h"
#include "server/kernel/kernel.h"

#include <new>

namespace heliograph {

void throwNoMemory() { throw std::bad_alloc(); }

namespace {

/// What decides how much light goes straight through a surface (straightThrough). Normal maps, layers and what else only reflects
/// do not, so that the walk has no code of them.
constexpr uint64_t WALK_EFFECTS = EFFECT_REFRACTIONS | EFFECT_ALPHA_BLEND | EFFECT_ABSORPTION | EFFECT_TEXTURES |
                                  EFFECT_VERTEX_COLORS | EFFECT_INSTANCING | EFFECT_SECOND_UV | EFFECT_ANISOTROPIC_TEXTURES |
                                  EFFECT_ROUGH_GLASS | EFFECT_PATH | EFFECT_NESTED_MEDIA | EFFECT_SHAPES;

using WalkKernel = scalar_kernel::Kernel<WALK_EFFECTS>;

// Flattened: in one piece, what the walk does not ask of a surface is not computed.
[[gnu::flatten]] vec3 walk(const TileJob& job, WalkKernel& kernel, vec3 from, vec3 direction, float left, uint32_t media,
                           uint64_t& rays) {
    vec3 through(1.0f);
    for (uint32_t step = 0; step <= WalkKernel::MAX_SHADOW_SURFACES; step++) {
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

}  // namespace

void transparentTransmittance(const TileJob& job, const RTCRay16& packet, uint32_t passed, const uint32_t* media, vec3* through,
                              uint64_t& rays) {
    WalkKernel kernel{*job.view, *job.frame};
    for (; passed; passed &= passed - 1) {
        const int i = __builtin_ctz(passed);
        const vec3 origin(packet.org_x[i], packet.org_y[i], packet.org_z[i]);
        const vec3 direction(packet.dir_x[i], packet.dir_y[i], packet.dir_z[i]);
        through[i] = walk(job, kernel, origin, direction, packet.tfar[i], media ? media[i] : 0, rays);
    }
}

}  // namespace heliograph

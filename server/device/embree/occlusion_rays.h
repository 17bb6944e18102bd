#pragma once
// Rays into the hemisphere, for ambient occlusion: points wait in groups of a packet and are traced sample by sample.

#include "server/device/embree/tile_arena.h"

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

template <uint64_t EFFECTS>
class OcclusionRays {
public:
    using KernelType = Kernel<EFFECTS>;
    using Path = typename KernelType::PathState;
    using Arrival = typename KernelType::Arrival;

    OcclusionRays(TileJob& job, Arena& arena, KernelType& kernel) : job_(job), arena_(arena), kernel_(kernel) {}

    /// Takes the points of a group whose `bits` are set.
    void push(const Group& g, uint32_t bits, const Path& path, const Arrival& a) {
        Vec3 origin = kernel_.offsetRayOrigin(a.surface.position, a.surface.geometricNormal, a.surface.clearance);
        Uint shift = kernel_.occlusionShift(Uvec2(g.load(arena_.pixelX), g.load(arena_.pixelY)), path.salt);
        for (; bits; bits &= bits - 1) {
            int i = __builtin_ctz(bits);
            uint32_t number = arena_.occlusionCount++;
            if (number / PACKET >= arena_.occlusion.capacity) arena_.occlusion.reserve(BLOCK_LANES / PACKET, number / PACKET);
            OcclusionGroup& to = arena_.occlusion.data[number / PACKET];
            uint32_t at = number % PACKET;
            putVector(to.origin, at, origin, i);
            putVector(to.normal, at, a.shading.normal, i);
            putVector(to.geometricNormal, at, a.surface.geometricNormal, i);
            putVector(to.ambient, at, a.ambient, i);
            to.shift[at] = shift.v[i];
            to.lane[at] = static_cast<uint16_t>(g.lane.v[i]);
        }
    }

    /// Traces the rays of sample `sample` from all points and adds what ambient light they leave.
    void trace(uint32_t sample) {
        uint32_t samples = kernel_.frame.aoSamples;
        RTCRay16& rays = arena_.packet.ray;
        TraceMode mode{job_.options.secondaryWidth, false};
        for (uint32_t first = 0; first < arena_.occlusionCount; first += PACKET) {
            OcclusionGroup& group = arena_.occlusion.data[first / PACKET];
            uint32_t points = lesser(PACKET, arena_.occlusionCount - first);
            uint32_t visible[PACKET] = {};
            Hemisphere hemispheres[PACKET / LANES];
            for (uint32_t at = 0; at < PACKET; at += LANES) hemispheres[at / LANES] = hemisphereOf(group, at);
            std::memcpy(rays.org_x, group.origin[0], sizeof rays.org_x);
            std::memcpy(rays.org_y, group.origin[1], sizeof rays.org_x);
            std::memcpy(rays.org_z, group.origin[2], sizeof rays.org_x);
            for (uint32_t index = 0; index < samples; index++) {
                const Uvec2 point = kernel_.sobolPoint(kernel_.occlusionNumber(sample, index));
                for (uint32_t at = 0; at < PACKET; at += LANES) aimOcclusion(hemispheres[at / LANES], at, point, rays);
                for (float& distance : rays.tfar) distance = kernel_.frame.aoDistance;
                uint32_t passed = 0;
                uint32_t blocked = traceOccluded(job_.rtcScene, rays, points, mode, passed);
                for (uint32_t i = 0; i < PACKET; i++) visible[i] += 1u - (blocked >> i & 1u);
            }
            job_.rays[static_cast<size_t>(RayKind::ambientOcclusion)] += uint64_t(samples) * points;
            for (uint32_t at = 0; at < points; at += LANES) addAmbient(group, at, lesser(LANES, points - at), visible);
        }
        arena_.occlusionCount = 0;
    }

private:
    static HELIOGRAPH_INLINE void putVector(float (&to)[3][PACKET], uint32_t at, const Vec3& v, int i) {
        to[0][at] = v.x.v[i];
        to[1][at] = v.y.v[i];
        to[2][at] = v.z.v[i];
    }

    static HELIOGRAPH_INLINE Vec3 getVector(const float (&from)[3][PACKET], uint32_t at) {
        VectorFloat x, y, z;
        std::memcpy(&x, from[0] + at, sizeof x);
        std::memcpy(&y, from[1] + at, sizeof y);
        std::memcpy(&z, from[2] + at, sizeof z);
        return {Float(x), Float(y), Float(z)};
    }

    /// Where the occlusion rays of LANES points go: the same for all of their samples.
    struct Hemisphere {
        Vec3 normal, geometricNormal, tangent, bitangent;
        Uint shift;
    };

    HELIOGRAPH_INLINE Hemisphere hemisphereOf(const OcclusionGroup& group, uint32_t at) {
        Hemisphere h;
        h.normal = getVector(group.normal, at);
        h.geometricNormal = getVector(group.geometricNormal, at);
        kernel_.orthonormalBasis(h.normal, h.tangent, h.bitangent);
        std::memcpy(&h.shift.v, group.shift + at, sizeof h.shift.v);
        return h;
    }

    HELIOGRAPH_INLINE void aimOcclusion(const Hemisphere& h, uint32_t at, const Uvec2& point, RTCRay16& rays) {
        Vec3 d = kernel_.occlusionDirection(point, h.shift, h.normal, h.geometricNormal, h.tangent, h.bitangent);
        std::memcpy(rays.dir_x + at, &d.x.v, sizeof d.x.v);
        std::memcpy(rays.dir_y + at, &d.y.v, sizeof d.x.v);
        std::memcpy(rays.dir_z + at, &d.z.v, sizeof d.x.v);
    }

    void addAmbient(const OcclusionGroup& group, uint32_t at, uint32_t points, const uint32_t* visible) {
        VectorUint seen;
        std::memcpy(&seen, visible + at, sizeof seen);
        Vec3 ambient = getVector(group.ambient, at) * kernel_.occlusionVisibility(Uint(seen));
        for (uint32_t i = 0; i < points; i++) {
            uint32_t lane = group.lane[at + i];
            arena_.radiance[0][lane] += ambient.x.v[i];
            arena_.radiance[1][lane] += ambient.y.v[i];
            arena_.radiance[2][lane] += ambient.z.v[i];
        }
    }

    TileJob& job_;
    Arena& arena_;
    KernelType& kernel_;
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

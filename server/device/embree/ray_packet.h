#pragma once
// Sixteen rays at a time, in the layout of Embree's widest packet, traced by the width that the processor has natively.

#include <embree3/rtcore.h>

#include "server/kernel/kernel_types.h"

namespace heliograph {

constexpr uint32_t PACKET = 16;
/// Rays look for hits beyond 0 (types.glsl, Ray), and Embree counts those at tnear: the smallest float that it takes for more.
constexpr float RAY_BEGIN = 1.17549435e-38f;

/// Embree's context with what the filter functions need beside it.
struct TraceContext {
    RTCIntersectContext rtc;
    const RTCRay16* rays = nullptr;  // the packet as sent, world space
    uint32_t passedTransparent = 0;  // bit per ray: an occlusion ray met a transparent surface
};

/// What rays are traced against, and which rays may be: Embree ends the process over others.
struct TraceTarget {
    RTCScene scene = nullptr;
    float rayReach = 0.0f;            // Scene::rayReach
    uint64_t* untraceable = nullptr;  // counts the rays that were left out, which meet nothing; may be null
};

/// How a group of rays is traced. Width 1 traces them one by one.
struct TraceMode {
    uint32_t width = 16;  // 1, 4, 8 or 16
    bool coherent = false;
};

/// Widest packet that the device traces natively: 16, 8 or 4.
uint32_t nativePacketWidth(RTCDevice device);

inline void setRay(RTCRay16& packet, uint32_t lane, vec3 origin, vec3 direction, float tMax, uint32_t mask = 0xffffffffu) {
    packet.org_x[lane] = origin.x;
    packet.org_y[lane] = origin.y;
    packet.org_z[lane] = origin.z;
    packet.tnear[lane] = RAY_BEGIN;
    packet.dir_x[lane] = direction.x;
    packet.dir_y[lane] = direction.y;
    packet.dir_z[lane] = direction.z;
    packet.time[lane] = 0.0f;
    packet.tfar[lane] = tMax;
    packet.mask[lane] = mask;
    packet.id[lane] = lane;
    packet.flags[lane] = 0;
}

inline vec3 rayOrigin(const RTCRay16& p, uint32_t lane) { return {p.org_x[lane], p.org_y[lane], p.org_z[lane]}; }
inline vec3 rayDirection(const RTCRay16& p, uint32_t lane) { return {p.dir_x[lane], p.dir_y[lane], p.dir_z[lane]}; }

/// Closest hits of the first `count` rays; geomID and instID tell what was hit, with width 1 or 16
/// tfar how far away.
void traceClosest(const TraceTarget& target, RTCRayHit16& packet, uint32_t count, TraceMode mode);

/// Any-hit test of the first `count` rays: bit per ray that is blocked by something opaque. `passedTransparent`: bit per
/// ray that met a transparent surface on its way.
uint32_t traceOccluded(const TraceTarget& target, RTCRay16& packet, uint32_t count, TraceMode mode,
                       uint32_t& passedTransparent);

}  // namespace heliograph

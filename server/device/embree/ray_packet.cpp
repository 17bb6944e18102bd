#include "server/device/embree/ray_packet.h"

#include <emmintrin.h>

#include <cstddef>
#include <cstring>
#include <type_traits>

namespace heliograph {

namespace {

TraceContext makeContext(const RTCRay16& rays, bool coherent) {
    TraceContext context;
    rtcInitIntersectContext(&context.rtc);
    context.rtc.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    context.rays = &rays;
    return context;
}

// The rays as sent. Embree moves the packet that it is given into an instance's space and back while it is inside, and the
// filters need the world's.
struct SentRays {
    RTCRay16 rays;
    SentRays(TraceContext& context, const RTCRay16& packet) {
        std::memcpy(&rays, &packet, offsetof(RTCRay16, time));  // origins and directions
        context.rays = &rays;
    }
};

// Which of the first `count` rays are traced: those that are valid to Embree in every instance's space. kernel/ray.glsl's
// isTraceable, four rays at a time; the last four are read whole.
struct alignas(64) ValidMask {
    int lane[PACKET] = {};
    uint32_t bits = 0;

    ValidMask(const TraceTarget& target, const RTCRay16& rays, uint32_t count) {
        const __m128 reach = _mm_set1_ps(target.rayReach), longest = _mm_set1_ps(2.0f);
        for (uint32_t i = 0; i < count; i += 4) {
            const __m128 end = _mm_load_ps(rays.tfar + i);
            const __m128 near = _mm_cmple_ps(sumOfSizes(rays.org_x + i, rays.org_y + i, rays.org_z + i), reach);
            const __m128 unit = _mm_cmple_ps(sumOfSizes(rays.dir_x + i, rays.dir_y + i, rays.dir_z + i), longest);
            const __m128i asked =
                _mm_cmplt_epi32(_mm_add_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(static_cast<int>(i))),
                                _mm_set1_epi32(static_cast<int>(count)));
            const __m128 valid =
                _mm_and_ps(_mm_and_ps(near, unit), _mm_and_ps(_mm_cmpord_ps(end, end), _mm_castsi128_ps(asked)));
            _mm_store_ps(reinterpret_cast<float*>(lane + i), valid);
            bits |= static_cast<uint32_t>(_mm_movemask_ps(valid)) << i;
        }
        if (target.untraceable) *target.untraceable += count - static_cast<uint32_t>(__builtin_popcount(bits));
    }

    bool operator[](uint32_t i) const { return (bits >> i & 1u) != 0; }

private:
    // |x| + |y| + |z|
    static __m128 sumOfSizes(const float* x, const float* y, const float* z) {
        const __m128 sign = _mm_set1_ps(-0.0f);
        return _mm_add_ps(_mm_add_ps(_mm_andnot_ps(sign, _mm_load_ps(x)), _mm_andnot_ps(sign, _mm_load_ps(y))),
                          _mm_andnot_ps(sign, _mm_load_ps(z)));
    }
};

// Makes the others rays without length: where a processor has no packets of 16, Embree takes all that have one, whatever the mask
// says, and ends the process over those that are not valid. Where they begin stays: who fills the lane next time sets no more than
// where the ray goes.
void silenceOthers(RTCRay16& rays, const ValidMask& valid) {
    for (uint32_t i = 0; i < PACKET; i++) {
        if (valid[i]) continue;
        rays.org_x[i] = rays.org_y[i] = rays.org_z[i] = rays.dir_x[i] = rays.dir_y[i] = 0.0f;
        rays.dir_z[i] = 1.0f;
        rays.tfar[i] = -1.0f;
    }
}

// Copies W rays from lane `first` of a 16-wide packet into a narrower one.
template <uint32_t W, typename Narrow>
void copyRays(Narrow& to, const RTCRay16& from, uint32_t first) {
    for (uint32_t i = 0; i < W; i++) {
        to.org_x[i] = from.org_x[first + i];
        to.org_y[i] = from.org_y[first + i];
        to.org_z[i] = from.org_z[first + i];
        to.tnear[i] = from.tnear[first + i];
        to.dir_x[i] = from.dir_x[first + i];
        to.dir_y[i] = from.dir_y[first + i];
        to.dir_z[i] = from.dir_z[first + i];
        to.time[i] = 0.0f;
        to.tfar[i] = from.tfar[first + i];
        to.mask[i] = from.mask[first + i];
        to.id[i] = from.id[first + i];
        to.flags[i] = 0;
    }
}

void copyRay(RTCRay& to, const RTCRay16& from, uint32_t i) {
    to.org_x = from.org_x[i];
    to.org_y = from.org_y[i];
    to.org_z = from.org_z[i];
    to.tnear = from.tnear[i];
    to.dir_x = from.dir_x[i];
    to.dir_y = from.dir_y[i];
    to.dir_z = from.dir_z[i];
    to.time = 0.0f;
    to.tfar = from.tfar[i];
    to.mask = from.mask[i];
    to.id = from.id[i];
    to.flags = 0;
}

template <uint32_t W, typename RayHit, typename Function>
void closestNarrow(const TraceTarget& target, RTCRayHit16& packet, uint32_t count, TraceContext& context, Function intersect) {
    const ValidMask valid(target, packet.ray, count);
    for (uint32_t first = 0; first < count; first += W) {
        alignas(64) RayHit narrow;
        copyRays<W>(narrow.ray, packet.ray, first);
        for (uint32_t i = 0; i < W; i++) {
            narrow.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            narrow.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect(valid.lane + first, target.scene, &context.rtc, &narrow);
        for (uint32_t i = 0; i < W; i++) {
            packet.hit.geomID[first + i] = narrow.hit.geomID[i];
            packet.hit.primID[first + i] = narrow.hit.primID[i];
            packet.hit.instID[0][first + i] = narrow.hit.instID[0][i];
        }
    }
}

void closestSingle(const TraceTarget& target, RTCRayHit16& packet, uint32_t count, TraceContext& context) {
    const ValidMask valid(target, packet.ray, count);
    for (uint32_t i = 0; i < count; i++) {
        RTCRayHit single;
        copyRay(single.ray, packet.ray, i);
        single.hit.geomID = single.hit.primID = RTC_INVALID_GEOMETRY_ID;
        single.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        if (valid[i]) rtcIntersect1(target.scene, &context.rtc, &single);
        packet.hit.geomID[i] = single.hit.geomID;
        packet.hit.primID[i] = single.hit.primID;
        packet.hit.instID[0][i] = single.hit.instID[0];
        packet.ray.tfar[i] = single.ray.tfar;
    }
}

template <uint32_t W, typename Narrow, typename Function>
uint32_t occludedNarrow(const TraceTarget& target, const RTCRay16& packet, uint32_t count, TraceContext& context,
                        Function occluded) {
    const ValidMask valid(target, packet, count);
    uint32_t blocked = 0;
    for (uint32_t first = 0; first < count; first += W) {
        alignas(64) Narrow narrow;
        copyRays<W>(narrow, packet, first);
        occluded(valid.lane + first, target.scene, &context.rtc, &narrow);
        for (uint32_t i = 0; i < W && first + i < count; i++)
            if (narrow.tfar[i] < 0.0f) blocked |= 1u << (first + i);
    }
    return blocked & valid.bits;
}

uint32_t occludedSingle(const TraceTarget& target, const RTCRay16& packet, uint32_t count, TraceContext& context) {
    const ValidMask valid(target, packet, count);
    uint32_t blocked = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (!valid[i]) continue;
        RTCRay single;
        copyRay(single, packet, i);
        rtcOccluded1(target.scene, &context.rtc, &single);
        if (single.tfar < 0.0f) blocked |= 1u << i;
    }
    return blocked;
}

}  // namespace

uint32_t nativePacketWidth(RTCDevice device) {
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return 8;
    return 4;
}

void traceClosest(const TraceTarget& target, RTCRayHit16& packet, uint32_t count, TraceMode mode) {
    TraceContext context = makeContext(packet.ray, mode.coherent);
    if (mode.width == 16) {
        const ValidMask valid(target, packet.ray, count);
        for (uint32_t i = 0; i < PACKET; i++) {
            packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        silenceOthers(packet.ray, valid);
        SentRays sent(context, packet.ray);
        rtcIntersect16(valid.lane, target.scene, &context.rtc, &packet);
    } else if (mode.width == 8) {
        closestNarrow<8, RTCRayHit8>(target, packet, count, context, rtcIntersect8);
    } else if (mode.width == 4) {
        closestNarrow<4, RTCRayHit4>(target, packet, count, context, rtcIntersect4);
    } else {
        closestSingle(target, packet, count, context);
    }
}

uint32_t traceOccluded(const TraceTarget& target, RTCRay16& packet, uint32_t count, TraceMode mode,
                       uint32_t& passedTransparent) {
    TraceContext context = makeContext(packet, mode.coherent);
    uint32_t blocked = 0;
    if (mode.width == 16) {
        const ValidMask valid(target, packet, count);
        silenceOthers(packet, valid);
        SentRays sent(context, packet);
        rtcOccluded16(valid.lane, target.scene, &context.rtc, &packet);
        for (uint32_t i = 0; i < count; i++) blocked |= (packet.tfar[i] < 0.0f ? 1u : 0u) << i;
        blocked &= valid.bits;
    } else if (mode.width == 8) {
        blocked = occludedNarrow<8, RTCRay8>(target, packet, count, context, rtcOccluded8);
    } else if (mode.width == 4) {
        blocked = occludedNarrow<4, RTCRay4>(target, packet, count, context, rtcOccluded4);
    } else {
        blocked = occludedSingle(target, packet, count, context);
    }
    passedTransparent = context.passedTransparent;
    return blocked;
}

}  // namespace heliograph

#pragma once
// Rays to the lights: the queue of each light, and what those that get through add to their pixels.

#include "server/device/embree/tile_arena.h"

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

template <uint64_t EFFECTS>
class ShadowRays {
public:
    using KernelType = Kernel<EFFECTS>;

    ShadowRays(TileJob& job, Arena& arena, KernelType& kernel) : job_(job), arena_(arena), kernel_(kernel) {
        while (arena_.shadows.size() < kernel_.allLights()) arena_.shadows.push_back(std::make_unique<ShadowQueue>());
    }

    /// Empties the queues and makes room for all rays of `points` points.
    void begin(uint32_t points) {
        for (uint32_t l = 0; l < kernel_.allLights(); l++)
            arena_.shadows[l]->reserve(points * (kernel_.lightSamples(l) + kernel_.fogRaysTo(l)), NESTS);
    }

    /// Queues the rays of a group that would add something. `media`: the bodies in which they begin.
    HELIOGRAPH_INLINE void push(uint32_t light, const Group& g, const typename KernelType::ShadowRay& shadow, Uint media) {
        uint32_t bits = laneBits(kernel_.isWorthRay(shadow.contribution)) & g.mask();
        if (!bits) return;
        ShadowQueue& queue = *arena_.shadows[light];
        if constexpr (NESTS) pushMedia(queue, bits, media);
        push(queue, g, bits, shadow.ray, shadow.contribution);
    }

    /// Traces what is queued. `width` as TraceMode has it; `fromEye`: the points were met by the camera's rays.
    void trace(uint32_t width, bool fromEye) {
        for (uint32_t l = 0; l < kernel_.allLights(); l++) traceLight(l, width, fromEye);
    }

private:
    static constexpr bool NESTS = (EFFECTS & EFFECT_NESTED_MEDIA) != 0;
    static constexpr uint32_t WORTH_SORTING = 64;  // rays
    static constexpr bool CATCHES = (EFFECTS & EFFECT_GROUND) != 0;

    /// As in effects/ground.glsl: a contribution that counts where something is in the way.
    static bool isTaken(vec3 contribution) {
        return CATCHES && (contribution.x < 0.0f || contribution.y < 0.0f || contribution.z < 0.0f);
    }

    HELIOGRAPH_INLINE void pushMedia(ShadowQueue& queue, uint32_t bits, Uint media) {
        for (uint32_t at = queue.count; bits; bits &= bits - 1) queue.media.data[at++] = media.v[__builtin_ctz(bits)];
    }

    HELIOGRAPH_INLINE void push(ShadowQueue& queue, const Group& g, uint32_t bits, const RayLanes& ray, Vec3 contribution) {
        const uint32_t full = LANES >= 32 ? ~0u : (1u << LANES) - 1u;
        if (bits == full && queue.count % LANES == 0) {
            RTCRay16& packet = queue.packets.data[queue.count / PACKET];
            uint32_t at = queue.count % PACKET;
            auto put = [at](float* row, Float x) { std::memcpy(row + at, &x.v, sizeof x.v); };
            put(packet.org_x, ray.origin.x);
            put(packet.org_y, ray.origin.y);
            put(packet.org_z, ray.origin.z);
            put(packet.dir_x, ray.direction.x);
            put(packet.dir_y, ray.direction.y);
            put(packet.dir_z, ray.direction.z);
            put(packet.tfar, ray.tMax);
            std::memcpy(queue.contribution[0].data + queue.count, &contribution.x.v, sizeof contribution.x.v);
            std::memcpy(queue.contribution[1].data + queue.count, &contribution.y.v, sizeof contribution.x.v);
            std::memcpy(queue.contribution[2].data + queue.count, &contribution.z.v, sizeof contribution.x.v);
            for (int i = 0; i < LANES; i++) queue.lanes.data[queue.count + i] = static_cast<uint16_t>(g.lane.v[i]);
            queue.count += LANES;
            return;
        }
        for (; bits; bits &= bits - 1) {
            int i = __builtin_ctz(bits);
            RTCRay16& packet = queue.packets.data[queue.count / PACKET];
            uint32_t at = queue.count % PACKET;
            packet.org_x[at] = ray.origin.x.v[i];
            packet.org_y[at] = ray.origin.y.v[i];
            packet.org_z[at] = ray.origin.z.v[i];
            packet.dir_x[at] = ray.direction.x.v[i];
            packet.dir_y[at] = ray.direction.y.v[i];
            packet.dir_z[at] = ray.direction.z.v[i];
            packet.tfar[at] = ray.tMax.v[i];
            queue.contribution[0].data[queue.count] = contribution.x.v[i];
            queue.contribution[1].data[queue.count] = contribution.y.v[i];
            queue.contribution[2].data[queue.count] = contribution.z.v[i];
            queue.lanes.data[queue.count++] = static_cast<uint16_t>(g.lane.v[i]);
        }
    }

    void traceLight(uint32_t light, uint32_t width, bool fromEye) {
        ShadowQueue& queue = *arena_.shadows[light];
        bool seen = fromEye && kernel_.shinesFromEye(light) != 0;  // by all that the camera's rays meet
        bool traced = (EFFECTS & kernel_.frame.effects & EFFECT_SHADOWS) != 0 && !seen;
        bool coloured = (EFFECTS & kernel_.frame.effects & EFFECT_TRANSPARENT_SHADOWS) != 0;  // else as if opaque
        TraceMode how{width, fromEye && job_.coherentShadows};
        if (traced) job_.rays[static_cast<size_t>(RayKind::shadow)] += queue.count;
        const bool scattered = traced && !fromEye && queue.count >= WORTH_SORTING && queue.count <= RayOrder::MOST;
        if (scattered) traceByDirection(queue, how);
        for (uint32_t first = 0; first < queue.count; first += PACKET) {
            RTCRay16& packet = queue.packets.data[first / PACKET];
            uint32_t rays = lesser(PACKET, queue.count - first);
            uint32_t blocked = 0;
            uint32_t passed = 0;
            if (scattered) {
                blocked = arena_.blocked.data[first / PACKET];
                passed = arena_.passed.data[first / PACKET];
            } else if (traced) {
                blocked = traceOccluded(job_.rtcScene, packet, rays, how, passed);
            }
            if (!coloured) blocked |= passed;
            passed &= ~blocked;
            vec3 through[PACKET];
            if (passed) walk(packet, passed, queue, first, through);
            for (uint32_t i = 0; i < rays; i++) {
                vec3 radiance(queue.contribution[0].data[first + i], queue.contribution[1].data[first + i],
                              queue.contribution[2].data[first + i]);
                const bool taken = isTaken(radiance);
                if ((blocked >> i & 1u) && !taken) continue;
                uint32_t lane = queue.lanes.data[first + i];
                if (passed >> i & 1u) {
                    radiance = radiance * (taken ? vec3(1.0f) - through[i] : through[i]);
                } else if (taken && !(blocked >> i & 1u)) {
                    continue;
                }
                arena_.radiance[0][lane] += radiance.x;
                arena_.radiance[1][lane] += radiance.y;
                arena_.radiance[2][lane] += radiance.z;
            }
        }
    }

    // Traces the queue in the order of the rays' directions, and tells the packets of the queue what they met.
    void traceByDirection(const ShadowQueue& queue, TraceMode how) {
        const uint32_t packets = (queue.count + PACKET - 1) / PACKET;
        for (Buffer<uint16_t>* bits : {&arena_.blocked, &arena_.passed}) {
            bits->reserve(packets);
            std::memset(bits->data, 0, packets * sizeof *bits->data);
        }
        const uint16_t* order = arena_.rayOrder.sort(queue.packets.data, queue.count);
        RTCRay16& rays = arena_.packet.ray;
        for (uint32_t first = 0; first < queue.count; first += PACKET) {
            const uint32_t count = lesser(PACKET, queue.count - first);
            for (uint32_t i = 0; i < count; i++)
                copyRay(rays, i, queue.packets.data[order[first + i] / PACKET], order[first + i] % PACKET);
            uint32_t passed = 0;
            const uint32_t blocked = traceOccluded(job_.rtcScene, rays, count, how, passed);
            tell(arena_.blocked, blocked, order + first);
            tell(arena_.passed, passed, order + first);
        }
    }

    static HELIOGRAPH_INLINE void copyRay(RTCRay16& to, uint32_t i, const RTCRay16& from, uint32_t at) {
        to.org_x[i] = from.org_x[at];
        to.org_y[i] = from.org_y[at];
        to.org_z[i] = from.org_z[at];
        to.dir_x[i] = from.dir_x[at];
        to.dir_y[i] = from.dir_y[at];
        to.dir_z[i] = from.dir_z[at];
        to.tfar[i] = from.tfar[at];
    }

    static void tell(Buffer<uint16_t>& packets, uint32_t met, const uint16_t* order) {
        for (; met; met &= met - 1) {
            const uint32_t ray = order[__builtin_ctz(met)];
            packets.data[ray / PACKET] = static_cast<uint16_t>(packets.data[ray / PACKET] | 1u << ray % PACKET);
        }
    }

    void walk(const RTCRay16& packet, uint32_t passed, const ShadowQueue& queue, uint32_t first, vec3* through) {
        transparentTransmittance(job_, packet, passed, NESTS ? queue.media.data + first : nullptr, through,
                                 job_.rays[static_cast<size_t>(RayKind::shadow)]);
    }

    TileJob& job_;
    Arena& arena_;
    KernelType& kernel_;
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

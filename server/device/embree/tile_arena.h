#pragma once
// Memory in which one thread renders tiles: paths and radiance as structures of arrays, occlusion rays in packets, pending
// paths on stacks. Allocated once, reused for every tile. Part of the tile programs: no shared inline code.

#include "server/device/embree/ray_order.h"
#include "server/kernel/kernel_lanes.h"

#include <memory>
#include <vector>

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

constexpr uint32_t BLOCK_LANES = 1024;  // pixels in work at once: a 32x32 block fits the second-level cache
constexpr uint32_t END = 0xffffffffu;

HELIOGRAPH_INLINE uint32_t lesser(uint32_t a, uint32_t b) { return a < b ? a : b; }

/// One value per pixel of the block in each array.
struct alignas(64) PathArrays {
    float origin[3][BLOCK_LANES];
    float direction[3][BLOCK_LANES];
    float throughput[3][BLOCK_LANES];
    float coneWidth[BLOCK_LANES];
    float coneSpread[BLOCK_LANES];
    uint32_t depth[BLOCK_LANES];
    uint32_t medium[BLOCK_LANES];
    uint32_t salt[BLOCK_LANES];
    float lobe[BLOCK_LANES];
    float way[BLOCK_LANES];
};

/// A path that waits.
struct StoredPath {
    float origin[3];
    float direction[3];
    float throughput[3];
    float coneWidth;
    float coneSpread;
    uint32_t depth;
    uint32_t medium;
    uint32_t salt;
    float lobe;
    float way;
    uint32_t below;  // next entry of the same pixel, END = none
};

/// The pixels' stacks of waiting paths: linked lists in one pool.
struct PathStacks {
    Buffer<StoredPath> pool;
    uint32_t used = 0;
    uint32_t freed = END;  // list of entries to use again
    uint32_t top[BLOCK_LANES];

    void clear(uint32_t lanes) {
        used = 0;
        freed = END;
        for (uint32_t i = 0; i < lanes; i++) top[i] = END;
    }
    StoredPath& push(uint32_t lane) {
        uint32_t index = freed;
        if (index != END) {
            freed = pool.data[index].below;
        } else {
            index = used++;
            if (index >= pool.capacity) pool.reserve(index < 1024 ? 2048 : index * 2, index);
        }
        pool.data[index].below = top[lane];
        top[lane] = index;
        return pool.data[index];
    }
    /// The topmost entry, taken off; null if there is none. Valid until the next push.
    const StoredPath* pop(uint32_t lane) {
        uint32_t index = top[lane];
        if (index == END) return nullptr;
        StoredPath* entry = &pool.data[index];
        top[lane] = entry->below;
        entry->below = freed;
        freed = index;
        return entry;
    }
};

/// What is the same for all rays; tracing leaves it alone.
HELIOGRAPH_INLINE void setConstants(RTCRay16& rays) {
    for (uint32_t i = 0; i < PACKET; i++) {
        rays.tnear[i] = RAY_BEGIN;
        rays.time[i] = 0.0f;
        rays.mask[i] = 0xffffffffu;
        rays.id[i] = i;
        rays.flags[i] = 0;
    }
}

/// Rays towards one light, packed without gaps in lane order, with what each adds to its pixel.
struct ShadowQueue {
    Buffer<RTCRay16> packets;
    Buffer<uint16_t> lanes;
    Buffer<float> contribution[3];
    Buffer<uint32_t> media;  // bodies in which the rays begin; only where bodies may nest
    uint32_t count = 0;
    void reserve(uint32_t rays, bool nests) {
        uint32_t rounded = (rays + PACKET - 1) / PACKET * PACKET;
        if (rounded / PACKET > packets.capacity) {
            packets.reserve(rounded / PACKET);
            for (uint32_t i = 0; i < packets.capacity; i++) setConstants(packets.data[i]);
        }
        lanes.reserve(rounded);
        if (nests) media.reserve(rounded);
        for (Buffer<float>& c : contribution) c.reserve(rounded);
        count = 0;
    }
};

/// Sixteen points that need ambient occlusion: a packet per sample.
struct alignas(64) OcclusionGroup {
    float origin[3][PACKET];
    float normal[3][PACKET];
    float geometricNormal[3][PACKET];
    float ambient[3][PACKET];
    uint32_t shift[PACKET];
    uint32_t visible[PACKET];
    uint16_t lane[PACKET];
};

struct Arena {
    PathArrays path;
    alignas(64) float radiance[3][BLOCK_LANES];
    alignas(64) uint32_t instance[BLOCK_LANES];
    alignas(64) uint32_t primitive[BLOCK_LANES];
    alignas(64) uint32_t pixelX[BLOCK_LANES];
    alignas(64) uint32_t pixelY[BLOCK_LANES];
    alignas(64) uint32_t relativeX[BLOCK_LANES];  // places of the lanes in a block of the size below
    alignas(64) uint32_t relativeY[BLOCK_LANES];
    uint32_t placedWidth = 0;
    uint32_t placedHeight = 0;
    uint16_t active[BLOCK_LANES + PACKET];
    uint16_t hits[BLOCK_LANES + PACKET];
    uint16_t misses[BLOCK_LANES + PACKET];
    uint16_t next[BLOCK_LANES];  // pixels whose path goes on, where none has to wait
    uint32_t activeCount = 0;
    uint32_t nextCount = 0;
    PathStacks stacks;
    std::vector<std::unique_ptr<ShadowQueue>> shadows;  // by light
    RayOrder rayOrder;
    Buffer<uint16_t> blocked;  // of the packets of a queue that was traced in another order: their rays that met something,
    Buffer<uint16_t> passed;   // and those that met what lets light through
    Buffer<OcclusionGroup> occlusion;
    uint32_t occlusionCount = 0;
    RTCRayHit16 packet;

    Arena() { setConstants(packet.ray); }
};

// ---- loads and stores of arrays with one value per pixel, for the pixels of a group ----

/// LANES pixels of the block, the last one repeated where there are fewer.
struct Group {
    Uint lane;
    uint32_t count;
    uint32_t first;   // lane of the first
    bool contiguous;  // lanes first, first + 1, ...

    static HELIOGRAPH_INLINE Group of(const uint16_t* lanes, uint32_t count) {
        Group g;
        g.count = count < uint32_t(LANES) ? count : uint32_t(LANES);
        g.first = lanes[0];
        g.contiguous = g.count == uint32_t(LANES) && lanes[LANES - 1] == lanes[0] + LANES - 1;
        for (int i = 0; i < LANES; i++) g.lane.v[i] = lanes[uint32_t(i) < g.count ? uint32_t(i) : g.count - 1];
        return g;
    }
    HELIOGRAPH_INLINE Float load(const float* values) const {
        VectorFloat v;
        if (contiguous) {
            std::memcpy(&v, values + first, sizeof v);
            return Float(v);
        }
        return Float((VectorFloat)gatherWords(values, lane, 4));
    }
    HELIOGRAPH_INLINE Uint load(const uint32_t* values) const {
        VectorUint v;
        if (contiguous) {
            std::memcpy(&v, values + first, sizeof v);
            return Uint(v);
        }
        return Uint((VectorUint)gatherWords(values, lane, 4));
    }
    HELIOGRAPH_INLINE Vec3 load(const float (&values)[3][BLOCK_LANES]) const {
        return {load(values[0]), load(values[1]), load(values[2])};
    }
    HELIOGRAPH_INLINE void store(float* values, Float x) const {
        if (contiguous) {
            std::memcpy(values + first, &x.v, sizeof x.v);
            return;
        }
        for (uint32_t i = 0; i < count; i++) values[lane.v[i]] = x.v[i];
    }
    HELIOGRAPH_INLINE void store(uint32_t* values, Uint x) const {
        if (contiguous) {
            std::memcpy(values + first, &x.v, sizeof x.v);
            return;
        }
        for (uint32_t i = 0; i < count; i++) values[lane.v[i]] = x.v[i];
    }
    HELIOGRAPH_INLINE void store(float (&values)[3][BLOCK_LANES], Vec3 x) const {
        store(values[0], x.x);
        store(values[1], x.y);
        store(values[2], x.z);
    }
    /// Those whose bits are set alone.
    HELIOGRAPH_INLINE void store(float* values, Float x, uint32_t bits) const {
        for (; bits; bits &= bits - 1) values[lane.v[__builtin_ctz(bits)]] = x.v[__builtin_ctz(bits)];
    }
    HELIOGRAPH_INLINE void store(uint32_t* values, Uint x, uint32_t bits) const {
        for (; bits; bits &= bits - 1) values[lane.v[__builtin_ctz(bits)]] = x.v[__builtin_ctz(bits)];
    }
    HELIOGRAPH_INLINE void store(float (&values)[3][BLOCK_LANES], Vec3 x, uint32_t bits) const {
        store(values[0], x.x, bits);
        store(values[1], x.y, bits);
        store(values[2], x.z, bits);
    }
    /// Bits of the lanes that count.
    HELIOGRAPH_INLINE uint32_t mask() const { return count >= 32 ? ~0u : (1u << count) - 1u; }
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

#pragma once
// The driver that runs the kernel's stages over a block of pixels: traces the rays of all pixels together, in packets,
// shades LANES points at a time, and keeps each pixel's pending rays on a stack, so that every pixel sums its
// contributions in the kernel's order whatever the block, packet or lane count. No shading maths here.

#include "server/device/embree/occlusion_rays.h"
#include "server/device/embree/shadow_rays.h"

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

template <uint64_t EFFECTS>
class TileTracer {
public:
    using KernelType = Kernel<EFFECTS>;
    using Path = typename KernelType::PathState;
    using Arrival = typename KernelType::Arrival;

    TileTracer(TileJob& job, Arena& arena)
        : job_(job),
          arena_(arena),
          kernel_{*job.view, *job.frame},
          shadows_(job, arena, kernel_),
          occlusion_(job, arena, kernel_) {}

    void render() {
        const Tile& tile = job_.tile;
        for (uint32_t sample = tile.firstSample; sample < tile.firstSample + tile.sampleCount; sample++)
            for (uint32_t y = 0; y < tile.size.y; y += 32)
                for (uint32_t x = 0; x < tile.size.x; x += 32)
                    renderBlock(x, y, lesser(32u, tile.size.x - x), lesser(32u, tile.size.y - y), sample);
    }

private:
    void count(RayKind kind, uint64_t rays) { job_.rays[static_cast<size_t>(kind)] += rays; }

    void renderBlock(uint32_t x, uint32_t y, uint32_t width, uint32_t height, uint32_t sample) {
        uint32_t lanes = placeLanes(job_.tile.origin.x + x, job_.tile.origin.y + y, width, height);
        sample_ = sample;
        secondary_ = false;
        arena_.stacks.clear(lanes);
        startPaths(lanes);
        if constexpr ((EFFECTS & EFFECT_GUIDES) != 0) renderGuides();
        else renderPaths(lanes);
        collect(lanes);
    }

    void renderPaths(uint32_t lanes) {
        while (arena_.activeCount > 0) {
            traceActive();
            shadeMisses();
            shadeHits();
            if (sendsOne()) takeNext();
            else popNext(lanes);
            secondary_ = true;
        }
    }

    void renderGuides() {
        traceActive();
        for (uint32_t first = 0; first < missCount_; first += LANES)
            Group::of(arena_.misses + first, missCount_ - first).store(arena_.radiance, kernel_.guidesOfMiss());
        for (uint32_t first = 0; first < hitCount_; first += LANES) {
            const Group g = Group::of(arena_.hits + first, hitCount_ - first);
            g.store(arena_.radiance, kernel_.guidesOf(loadPath(g), hitOf(g)));
        }
    }

    // Pixels in 4x4 groups, so that a packet looks through a square.
    uint32_t placeLanes(uint32_t left, uint32_t top, uint32_t width, uint32_t height) {
        if (arena_.placedWidth != width || arena_.placedHeight != height) {
            uint32_t lanes = 0;
            for (uint32_t y = 0; y < height; y += 4)
                for (uint32_t x = 0; x < width; x += 4)
                    for (uint32_t j = y; j < lesser(y + 4, height); j++)
                        for (uint32_t i = x; i < lesser(x + 4, width); i++) {
                            arena_.relativeX[lanes] = i;
                            arena_.relativeY[lanes++] = j;
                        }
            arena_.placedWidth = width;
            arena_.placedHeight = height;
        }
        uint32_t lanes = width * height;
        for (uint32_t i = 0; i < lanes; i++) {
            arena_.pixelX[i] = left + arena_.relativeX[i];
            arena_.pixelY[i] = top + arena_.relativeY[i];
        }
        return lanes;
    }

    void startPaths(uint32_t lanes) {
        for (uint32_t i = 0; i < lanes; i++) arena_.active[i] = static_cast<uint16_t>(i);
        arena_.activeCount = lanes;
        for (uint32_t first = 0; first < lanes; first += LANES) {
            Group g = Group::of(arena_.active + first, lanes - first);
            storePath(g, kernel_.startSample(Uvec2(g.load(arena_.pixelX), g.load(arena_.pixelY)), sample_));
            g.store(arena_.radiance, Vec3(glm::vec3(0.0f)));
        }
    }

    HELIOGRAPH_INLINE void storePath(const Group& g, const Path& path) {
        PathArrays& to = arena_.path;
        g.store(to.origin, path.origin);
        g.store(to.direction, path.direction);
        g.store(to.throughput, path.throughput);
        g.store(to.coneWidth, path.coneWidth);
        g.store(to.coneSpread, path.coneSpread);
        g.store(to.depth, path.depth);
        g.store(to.medium, path.medium);
        g.store(to.salt, path.salt);
        g.store(to.lobe, path.lobe);
        g.store(to.way, path.way);
    }

    HELIOGRAPH_INLINE Path loadPath(const Group& g) const {
        const PathArrays& from = arena_.path;
        Path path;
        path.origin = g.load(from.origin);
        path.direction = g.load(from.direction);
        path.throughput = g.load(from.throughput);
        path.coneWidth = g.load(from.coneWidth);
        path.coneSpread = g.load(from.coneSpread);
        path.depth = g.load(from.depth);
        path.medium = g.load(from.medium);
        path.salt = g.load(from.salt);
        path.lobe = g.load(from.lobe);
        path.way = g.load(from.way);
        return path;
    }

    // Whether at most one path goes on from a hit, so that none has to wait.
    bool sendsOne() const { return (EFFECTS & kernel_.frame.effects & EFFECT_PATH) != 0; }

    void takeNext() {
        arena_.activeCount = arena_.nextCount;
        std::memcpy(arena_.active, arena_.next, arena_.nextCount * sizeof *arena_.next);
        arena_.nextCount = 0;
    }

    void popNext(uint32_t lanes) {
        arena_.activeCount = 0;
        if (arena_.stacks.used == 0) return;
        for (uint32_t lane = 0; lane < lanes; lane++) {
            const StoredPath* stored = arena_.stacks.pop(lane);
            if (!stored) continue;
            PathArrays& path = arena_.path;
            for (int axis = 0; axis < 3; axis++) {
                path.origin[axis][lane] = stored->origin[axis];
                path.direction[axis][lane] = stored->direction[axis];
                path.throughput[axis][lane] = stored->throughput[axis];
            }
            path.coneWidth[lane] = stored->coneWidth;
            path.coneSpread[lane] = stored->coneSpread;
            path.depth[lane] = stored->depth;
            path.medium[lane] = stored->medium;
            path.salt[lane] = stored->salt;
            path.lobe[lane] = stored->lobe;
            path.way[lane] = stored->way;
            arena_.active[arena_.activeCount++] = static_cast<uint16_t>(lane);
        }
    }

    // Camera rays and the shadow rays at their hits go through like space together; the others don't.
    TraceMode mode() const {
        return {secondary_ ? job_.options.secondaryWidth : job_.options.primaryWidth, !secondary_ && job_.coherentPrimary};
    }

    void traceActive() {
        RTCRayHit16& packet = arena_.packet;
        hitCount_ = 0;
        missCount_ = 0;
        for (uint32_t first = 0; first < arena_.activeCount; first += PACKET) {
            const uint16_t* lanes = arena_.active + first;
            uint32_t count = lesser(PACKET, arena_.activeCount - first);
            fillPacket(packet.ray, lanes, count);
            traceClosest(job_.rtcScene, packet, count, mode());
            noteHits(packet, lanes, count);
        }
        countActive();
    }

    void noteHits(const RTCRayHit16& packet, const uint16_t* lanes, uint32_t count) {
        uint32_t instance[PACKET];
        bool whole = count == PACKET && lanes[PACKET - 1] == lanes[0] + PACKET - 1;
        uint32_t misses = 0;
        for (uint32_t i = 0; i < PACKET; i++) {
            uint32_t placed = packet.hit.instID[0][i];
            instance[i] = placed != RTC_INVALID_GEOMETRY_ID ? placed : packet.hit.geomID[i];
            misses += instance[i] == NO_INDEX;
        }
        if (whole && misses == 0) {
            std::memcpy(arena_.instance + lanes[0], instance, sizeof instance);
            std::memcpy(arena_.primitive + lanes[0], packet.hit.primID, sizeof instance);
            std::memcpy(arena_.hits + hitCount_, lanes, PACKET * sizeof *lanes);
            hitCount_ += PACKET;
            return;
        }
        for (uint32_t i = 0; i < count; i++) {
            arena_.instance[lanes[i]] = instance[i];
            arena_.primitive[lanes[i]] = packet.hit.primID[i];
            bool hit = instance[i] != NO_INDEX;
            arena_.hits[hitCount_] = lanes[i];
            arena_.misses[missCount_] = lanes[i];
            hitCount_ += hit;
            missCount_ += !hit;
        }
    }

    void countActive() {
        if (!secondary_) {
            count(RayKind::primary, arena_.activeCount);
            return;
        }
        for (uint32_t i = 0; i < arena_.activeCount; i++)
            count((arena_.path.depth[arena_.active[i]] & KernelType::RAY_KIND_BITS) >> 24 == KernelType::RAY_REFLECTION
                      ? RayKind::reflection
                      : RayKind::refraction,
                  1);
    }

    void fillPacket(RTCRay16& rays, const uint16_t* lanes, uint32_t count) {
        const PathArrays& path = arena_.path;
        if (count == PACKET && lanes[PACKET - 1] == lanes[0] + PACKET - 1) {
            std::memcpy(rays.org_x, path.origin[0] + lanes[0], sizeof rays.org_x);
            std::memcpy(rays.org_y, path.origin[1] + lanes[0], sizeof rays.org_x);
            std::memcpy(rays.org_z, path.origin[2] + lanes[0], sizeof rays.org_x);
            std::memcpy(rays.dir_x, path.direction[0] + lanes[0], sizeof rays.org_x);
            std::memcpy(rays.dir_y, path.direction[1] + lanes[0], sizeof rays.org_x);
            std::memcpy(rays.dir_z, path.direction[2] + lanes[0], sizeof rays.org_x);
        } else {
            for (uint32_t i = 0; i < count; i++) {
                rays.org_x[i] = path.origin[0][lanes[i]];
                rays.org_y[i] = path.origin[1][lanes[i]];
                rays.org_z[i] = path.origin[2][lanes[i]];
                rays.dir_x[i] = path.direction[0][lanes[i]];
                rays.dir_y[i] = path.direction[1][lanes[i]];
                rays.dir_z[i] = path.direction[2][lanes[i]];
            }
        }
        for (float& distance : rays.tfar) distance = KernelType::FLOAT_MAX;
    }

    void shadeMisses() {
        for (uint32_t first = 0; first < missCount_; first += LANES) {
            Group g = Group::of(arena_.misses + first, missCount_ - first);
            g.store(arena_.radiance, g.load(arena_.radiance) + kernel_.missRadiance(loadPath(g)));
        }
        if constexpr ((EFFECTS & EFFECT_GROUND) != 0) shadeGround();
        if (kernel_.fogRays() == 0) return;
        shadeRuns(missCount_, [&](uint32_t i, uint32_t end) {
            const Group g = Group::of(arena_.misses + i, end - i);
            Path path = loadPath(g);
            for (uint32_t l = 0; l < kernel_.allLights(); l++) pushFog(l, g, path, kernel_.airOfMiss(path));
        });
    }

    // Misses that look at the ground; with it there is no fog, so that nobody asks for the others again.
    void shadeGround() {
        if ((kernel_.frame.layers & (EFFECT_GROUND >> 32)) == 0) return;
        uint32_t count = 0;
        for (uint32_t first = 0; first < missCount_; first += LANES) {
            const Group g = Group::of(arena_.misses + first, missCount_ - first);
            uint32_t met = laneBits(kernel_.meetsGround(loadPath(g))) & g.mask();
            for (; met; met &= met - 1) arena_.misses[count++] = static_cast<uint16_t>(g.lane.v[__builtin_ctz(met)]);
        }
        shadeRuns(count, [&](uint32_t i, uint32_t end) {
            const Group g = Group::of(arena_.misses + i, end - i);
            Path path = loadPath(g);
            Vec3 radiance = g.load(arena_.radiance);
            const Arrival a = kernel_.onGround(path, radiance);
            g.store(arena_.radiance, radiance);
            gatherLight(g, path, a);
        });
    }

    void shadeHits() {
        shadeRuns(hitCount_, [&](uint32_t i, uint32_t end) { shadeGroup(Group::of(arena_.hits + i, end - i)); });
    }

    // Calls `shade(i, end)` for `count` points, LANES at a time, and traces the light and occlusion rays that it pushes. Many
    // light rays a point take the points in smaller runs, so that the queues stay small.
    template <typename Shade>
    HELIOGRAPH_INLINE void shadeRuns(uint32_t count, const Shade& shade) {
        uint32_t rays = kernel_.allLightSamples() + kernel_.allFogRays();
        uint32_t run = rays > 8 ? lesser(BLOCK_LANES, (8192u / rays + PACKET) / PACKET * PACKET) : BLOCK_LANES;
        for (uint32_t first = 0; first < count; first += run) {
            uint32_t end = lesser(first + run, count);
            shadows_.begin(end - first);
            for (uint32_t i = first; i < end; i += LANES) shade(i, end);
            shadows_.trace(mode().width, !secondary_);
            occlusion_.trace(sample_);
        }
    }

    HELIOGRAPH_INLINE HitLanes hitOf(const Group& g) const {
        HitLanes hit;
        hit.instance = g.load(arena_.instance);
        hit.primitive = g.load(arena_.primitive);
        return hit;
    }

    // What LANES hits add at once, and the rays and paths that they send.
    void shadeGroup(const Group g) {
        Path path = loadPath(g);
        const HitLanes hit = hitOf(g);
        Uvec2 pixel(g.load(arena_.pixelX), g.load(arena_.pixelY));
        Vec3 radiance = g.load(arena_.radiance);
        const Arrival a = kernel_.arrive(pixel, sample_, path, hit, radiance);
        g.store(arena_.radiance, radiance);
        pushNext(g, a);
        if constexpr ((EFFECTS & EFFECT_NESTED_MEDIA) != 0) countLost(g, a.mediaLost);
        gatherLight(g, path, a);
    }

    // Queues the rays to the lights and into the hemisphere. Where two stages do it, they share the code.
    HELIOGRAPH_INLINE void gatherLight(const Group& g, const Path& path, const Arrival& a) {
        if constexpr ((EFFECTS & EFFECT_GROUND) != 0) queueLight(g, path, a);
        else queueLightHere(g, path, a);
    }
    [[gnu::noinline]] void queueLight(const Group& g, const Path& path, const Arrival& a) { queueLightHere(g, path, a); }
    HELIOGRAPH_INLINE void queueLightHere(const Group& g, const Path& path, const Arrival& a) {
        const Uvec2 pixel(g.load(arena_.pixelX), g.load(arena_.pixelY));
        if (uint32_t bits = laneBits(a.occlusion) & g.mask()) occlusion_.push(g, bits, path, a);
        for (uint32_t l = 0; l < kernel_.allLights(); l++) {
            uint32_t own = kernel_.raysFromSurface(l, 1);
            for (uint32_t i = 0; i < own + kernel_.fogRaysTo(l); i++)
                shadows_.push(l, g, kernel_.rayToLight(l, i, own, sample_, pixel, path, a), a.media);
        }
    }

    // Rays to a light from points of the paths' way through `air` metres of fog.
    void pushFog(uint32_t light, const Group& g, const Path& path, Float air) {
        Uvec2 pixel(g.load(arena_.pixelX), g.load(arena_.pixelY));
        for (uint32_t i = 0; i < kernel_.fogRaysTo(light); i++)
            shadows_.push(light, g, kernel_.pathFogRay(light, i, sample_, pixel, path, air), path.medium);
    }

    void countLost(const Group& g, Uint lost) {
        const auto having = [&](uint32_t bit) {
            return static_cast<uint32_t>(__builtin_popcount(laneBits((lost & Uint(bit)) != Uint(0u)) & g.mask()));
        };
        job_.mediaUnderflows += having(KernelType::MEDIA_UNDERFLOW);
        job_.mediaOverflows += having(KernelType::MEDIA_OVERFLOW);
    }

    // Puts those of `path` whose bits are set in the place of the paths of their pixels.
    HELIOGRAPH_INLINE void replacePath(const Group& g, const Path& path, uint32_t bits) {
        PathArrays& to = arena_.path;
        g.store(to.origin, path.origin, bits);
        g.store(to.direction, path.direction, bits);
        g.store(to.throughput, path.throughput, bits);
        g.store(to.coneWidth, path.coneWidth, bits);
        g.store(to.coneSpread, path.coneSpread, bits);
        g.store(to.depth, path.depth, bits);
        g.store(to.medium, path.medium, bits);
        g.store(to.salt, path.salt, bits);
        g.store(to.lobe, path.lobe, bits);
        g.store(to.way, path.way, bits);
    }

    HELIOGRAPH_INLINE void goOn(const Group& g, const Arrival& a) {
        uint32_t some = laneBits(a.next != Uint(0u)) & g.mask();
#define HAS_LAYER(effect) ((EFFECTS & (effect)) != 0)
#define REPLACE(bit, path) \
    if (uint32_t bits = laneBits((a.next & Uint(uint32_t(KernelType::bit))) != Uint(0u)) & some) replacePath(g, a.path, bits);
        FOR_NEXT_PATHS(REPLACE)
#undef REPLACE
#undef HAS_LAYER
        for (; some; some &= some - 1) arena_.next[arena_.nextCount++] = static_cast<uint16_t>(g.lane.v[__builtin_ctz(some)]);
    }

    HELIOGRAPH_INLINE void pushNext(const Group& g, const Arrival& a) {
        if (sendsOne()) {
            goOn(g, a);
            return;
        }
        uint32_t some = laneBits(a.next != Uint(0u)) & g.mask();
        for (; some; some &= some - 1) {
            int i = __builtin_ctz(some);
            uint32_t next = a.next.v[i];
            uint32_t lane = g.lane.v[i];
#define HAS_LAYER(effect) ((EFFECTS & (effect)) != 0)
#define PUSH(bit, path) \
    if (next & KernelType::bit) storeLane(arena_.stacks.push(lane), a.path, i);
            FOR_NEXT_PATHS(PUSH)
#undef PUSH
#undef HAS_LAYER
        }
    }

    static void storeLane(StoredPath& to, const Path& from, int i) {
        to.origin[0] = from.origin.x.v[i];
        to.origin[1] = from.origin.y.v[i];
        to.origin[2] = from.origin.z.v[i];
        to.direction[0] = from.direction.x.v[i];
        to.direction[1] = from.direction.y.v[i];
        to.direction[2] = from.direction.z.v[i];
        to.throughput[0] = from.throughput.x.v[i];
        to.throughput[1] = from.throughput.y.v[i];
        to.throughput[2] = from.throughput.z.v[i];
        to.coneWidth = from.coneWidth.v[i];
        to.coneSpread = from.coneSpread.v[i];
        to.depth = from.depth.v[i];
        to.medium = from.medium.v[i];
        to.salt = from.salt.v[i];
        to.lobe = from.lobe.v[i];
        to.way = from.way.v[i];
    }

    void collect(uint32_t lanes) {
        alignas(64) float squared[LANES];
        for (uint32_t first = 0; first < lanes; first += LANES) {
            Group g;
            g.first = first;
            g.count = lesser(LANES, lanes - first);
            g.contiguous = true;  // reads past the last pixel stay inside the arrays
            Vec3 radiance = g.load(arena_.radiance);
            Float y = kernel_.luminance(radiance);
            y = y * y;
            std::memcpy(squared, &y.v, sizeof squared);
            uint32_t finite = laneBits(kernel_.isFinite3(radiance)) & g.mask();
            job_.nonfiniteSamples += g.count - static_cast<uint32_t>(__builtin_popcount(finite));
            for (uint32_t i = 0; i < g.count; i++) {
                if (!(finite >> i & 1u)) continue;
                uint32_t lane = first + i;
                uint32_t x = arena_.pixelX[lane] - job_.tile.origin.x;
                uint32_t row = arena_.pixelY[lane] - job_.tile.origin.y;
                float* sum = &job_.radianceSum[size_t(row) * job_.tile.size.x + x].x;
                __m128 add =
                    _mm_setr_ps(arena_.radiance[0][lane], arena_.radiance[1][lane], arena_.radiance[2][lane], squared[i]);
                _mm_storeu_ps(sum, _mm_add_ps(_mm_loadu_ps(sum), add));
            }
        }
    }

    TileJob& job_;
    Arena& arena_;
    KernelType kernel_;
    ShadowRays<EFFECTS> shadows_;
    OcclusionRays<EFFECTS> occlusion_;
    uint32_t sample_ = 0;
    uint32_t hitCount_ = 0;
    uint32_t missCount_ = 0;
    bool secondary_ = false;
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

#pragma once
// The driver that runs the kernel's stages over a block of pixels: traces the rays of all pixels together, in packets,
// shades LANES points at a time, and keeps each pixel's pending rays on a stack, so that every pixel sums its
// contributions in the kernel's order whatever the block, packet or lane count. No shading maths here.

#include "server/device/embree/tile_arena.h"

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

template <uint32_t EFFECTS>
class TileTracer {
public:
    using KernelType = Kernel<EFFECTS>;
    using Path = typename KernelType::PathState;
    using Arrival = typename KernelType::Arrival;

    TileTracer(TileJob& job, Arena& arena) : job_(job), arena_(arena) {
        kernel_.scene = *job.view;
        kernel_.frame = *job.frame;
        while (arena_.shadowQueues < kernel_.frame.lightCount) {
            arena_.shadows.reserve(arena_.shadowQueues + 16, arena_.shadowQueues);
            arena_.shadows.data[arena_.shadowQueues++] = new ShadowQueue();
        }
    }

    void render() {
        const Tile& tile = job_.tile;
        for (uint32_t sample = tile.firstSample; sample < tile.firstSample + tile.sampleCount; sample++)
            for (uint32_t y = 0; y < tile.size.y; y += 32)
                for (uint32_t x = 0; x < tile.size.x; x += 32)
                    renderBlock(x, y, lesser(32u, tile.size.x - x), lesser(32u, tile.size.y - y), sample);
    }

private:
    static HELIOGRAPH_INLINE uint32_t lesser(uint32_t a, uint32_t b) { return a < b ? a : b; }
    void count(RayKind kind, uint64_t rays) { job_.rays[static_cast<size_t>(kind)] += rays; }

    void renderBlock(uint32_t x, uint32_t y, uint32_t width, uint32_t height, uint32_t sample) {
        uint32_t lanes = placeLanes(job_.tile.origin.x + x, job_.tile.origin.y + y, width, height);
        sample_ = sample;
        secondary_ = false;
        arena_.stacks.clear(lanes);
        startPaths(lanes);
        while (arena_.activeCount > 0) {
            traceActive();
            shadeMisses();
            shadeHits();
            popNext(lanes);
            secondary_ = true;
        }
        collect(lanes);
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
        return path;
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
            arena_.active[arena_.activeCount++] = static_cast<uint16_t>(lane);
        }
    }

    // Camera rays and the shadow rays at their hits go through like space together; the others don't.
    TraceMode mode() const {
        return {secondary_ ? job_.options.secondaryWidth : job_.options.primaryWidth,
                !secondary_ && job_.coherentPrimary};
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
            count(arena_.path.depth[arena_.active[i]] >> 24 == KernelType::RAY_REFLECTION ? RayKind::reflection
                                                                                        : RayKind::refraction, 1);
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
        if (kernel_.fogRays() == 0) return;
        shadeRuns(missCount_, [&](uint32_t i, uint32_t end) {
            const Group g = Group::of(arena_.misses + i, end - i);
            Path path = loadPath(g);
            for (uint32_t l = 0; l < kernel_.frame.lightCount; l++) pushFog(l, g, path, kernel_.airOfMiss(path));
        });
    }

    void shadeHits() {
        shadeRuns(hitCount_, [&](uint32_t i, uint32_t end) { shadeGroup(Group::of(arena_.hits + i, end - i)); });
    }

    // Calls `shade(i, end)` for `count` points, LANES at a time, and traces the light and occlusion rays that it pushes. Many
    // light rays a point take the points in smaller runs, so that the queues stay small.
    template <typename Shade>
    HELIOGRAPH_INLINE void shadeRuns(uint32_t count, const Shade& shade) {
        uint32_t lights = kernel_.frame.lightCount;
        uint32_t rays = kernel_.allLightSamples() + lights * kernel_.fogRays();
        uint32_t run = rays > 8 ? lesser(BLOCK_LANES, (8192u / rays + PACKET) / PACKET * PACKET) : BLOCK_LANES;
        for (uint32_t l = 0; l < lights; l++)
            arena_.shadows.data[l]->reserve(lesser(run, count) * (kernel_.lightSamples(l) + kernel_.fogRays()));
        for (uint32_t first = 0; first < count; first += run) {
            uint32_t end = lesser(first + run, count);
            for (uint32_t l = 0; l < lights; l++) arena_.shadows.data[l]->count = 0;
            arena_.occlusionCount = 0;
            for (uint32_t i = first; i < end; i += LANES) shade(i, end);
            for (uint32_t l = 0; l < lights; l++) traceShadows(l);
            traceOcclusion();
        }
    }

    // What LANES hits add at once, and the rays and paths that they send.
    void shadeGroup(const Group g) {
        Path path = loadPath(g);
        HitLanes hit;
        hit.instance = g.load(arena_.instance);
        hit.primitive = g.load(arena_.primitive);
        Uvec2 pixel(g.load(arena_.pixelX), g.load(arena_.pixelY));
        Vec3 radiance = g.load(arena_.radiance);
        const Arrival a = kernel_.arrive(pixel, sample_, path, hit, radiance);
        g.store(arena_.radiance, radiance);
        if (uint32_t bits = laneBits(a.occlusion) & g.mask()) pushOcclusion(g, bits, path, a);
        pushNext(g, a);
        for (uint32_t l = 0; l < kernel_.frame.lightCount; l++) {
            uint32_t own = kernel_.raysFromSurface(l, 1);
            for (uint32_t i = 0; i < own + kernel_.fogRays(); i++)
                pushShadow(l, g, kernel_.rayToLight(l, i, own, sample_, pixel, path, a));
        }
    }

    // Rays to a light from points of the paths' way through `air` metres of fog.
    void pushFog(uint32_t light, const Group& g, const Path& path, Float air) {
        Uvec2 pixel(g.load(arena_.pixelX), g.load(arena_.pixelY));
        for (uint32_t i = 0; i < kernel_.fogRays(); i++)
            pushShadow(light, g, kernel_.pathFogRay(light, i, sample_, pixel, path, air));
    }

    HELIOGRAPH_INLINE void pushNext(const Group& g, const Arrival& a) {
        uint32_t some = laneBits(a.next != Uint(0u)) & g.mask();
        for (; some; some &= some - 1) {
            int i = __builtin_ctz(some);
            uint32_t next = a.next.v[i];
            uint32_t lane = g.lane.v[i];
#define PUSH(bit, path) if (next & KernelType::bit) storeLane(arena_.stacks.push(lane), a.path, i);
            FOR_NEXT_PATHS(PUSH)
#undef PUSH
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
    }

    HELIOGRAPH_INLINE void pushShadow(uint32_t light, const Group& g, const typename KernelType::ShadowRay& shadow) {
        uint32_t bits = laneBits(kernel_.maxComponent(shadow.contribution) > 0.0f) & g.mask();
        if (bits) pushShadow(*arena_.shadows.data[light], g, bits, shadow.ray, shadow.contribution);
    }

    HELIOGRAPH_INLINE void pushShadow(ShadowQueue& queue, const Group& g, uint32_t bits, const RayLanes& ray,
                                      Vec3 contribution) {
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

    void traceShadows(uint32_t light) {
        ShadowQueue& queue = *arena_.shadows.data[light];
        bool seen = !secondary_ && kernel_.shinesFromEye(light) != 0;  // by all that the camera's rays meet
        bool traced = (EFFECTS & kernel_.frame.effects & EFFECT_SHADOWS) != 0 && !seen;
        bool coloured = (EFFECTS & kernel_.frame.effects & EFFECT_TRANSPARENT_SHADOWS) != 0;  // else as if opaque
        TraceMode how{mode().width, !secondary_ && job_.coherentShadows};
        if (traced) count(RayKind::shadow, queue.count);
        for (uint32_t first = 0; first < queue.count; first += PACKET) {
            RTCRay16& packet = queue.packets.data[first / PACKET];
            uint32_t rays = lesser(PACKET, queue.count - first);
            uint32_t blocked = 0;
            uint32_t passed = 0;
            if (traced) {
                blocked = traceOccluded(job_.rtcScene, packet, rays, how, passed);
                if (!coloured) blocked |= passed;
                passed &= ~blocked;
            }
            for (uint32_t i = 0; i < rays; i++) {
                if (blocked >> i & 1u) continue;
                uint32_t lane = queue.lanes.data[first + i];
                vec3 radiance(queue.contribution[0].data[first + i], queue.contribution[1].data[first + i],
                              queue.contribution[2].data[first + i]);
                if (passed >> i & 1u) radiance = radiance * throughTransparent(packet, i);
                arena_.radiance[0][lane] += radiance.x;
                arena_.radiance[1][lane] += radiance.y;
                arena_.radiance[2][lane] += radiance.z;
            }
        }
    }

    vec3 throughTransparent(const RTCRay16& packet, uint32_t i) {
        vec3 origin(packet.org_x[i], packet.org_y[i], packet.org_z[i]);
        vec3 direction(packet.dir_x[i], packet.dir_y[i], packet.dir_z[i]);
        return transparentTransmittance(job_, origin, direction, packet.tfar[i],
                                        job_.rays[static_cast<size_t>(RayKind::shadow)]);
    }

    void pushOcclusion(const Group& g, uint32_t bits, const Path& path, const Arrival& a) {
        Vec3 origin = kernel_.offsetRayOrigin(a.surface.position, a.surface.geometricNormal);
        Uint shift = kernel_.occlusionShift(Uvec2(g.load(arena_.pixelX), g.load(arena_.pixelY)), path.salt);
        for (; bits; bits &= bits - 1) {
            int i = __builtin_ctz(bits);
            uint32_t number = arena_.occlusionCount++;
            if (number / PACKET >= arena_.occlusion.capacity)
                arena_.occlusion.reserve(BLOCK_LANES / PACKET, number / PACKET);
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

    void traceOcclusion() {
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
                uvec2 point = kernel_.scene.sobol[kernel_.occlusionNumber(sample_, index)];
                for (uint32_t at = 0; at < PACKET; at += LANES) aimOcclusion(hemispheres[at / LANES], at, point, rays);
                for (float& distance : rays.tfar) distance = kernel_.frame.aoDistance;
                uint32_t passed = 0;
                uint32_t blocked = traceOccluded(job_.rtcScene, rays, points, mode, passed);
                for (uint32_t i = 0; i < PACKET; i++) visible[i] += 1u - (blocked >> i & 1u);
            }
            count(RayKind::ambientOcclusion, uint64_t(samples) * points);
            for (uint32_t at = 0; at < points; at += LANES) addAmbient(group, at, lesser(LANES, points - at), visible);
        }
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

    HELIOGRAPH_INLINE void aimOcclusion(const Hemisphere& h, uint32_t at, uvec2 point, RTCRay16& rays) {
        Vec3 d = kernel_.occlusionDirection(Uvec2(point), h.shift, h.normal, h.geometricNormal, h.tangent, h.bitangent);
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
                __m128 add = _mm_setr_ps(arena_.radiance[0][lane], arena_.radiance[1][lane], arena_.radiance[2][lane],
                                         squared[i]);
                _mm_storeu_ps(sum, _mm_add_ps(_mm_loadu_ps(sum), add));
            }
        }
    }

    TileJob& job_;
    Arena& arena_;
    KernelType kernel_;
    uint32_t sample_ = 0;
    uint32_t hitCount_ = 0;
    uint32_t missCount_ = 0;
    bool secondary_ = false;
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

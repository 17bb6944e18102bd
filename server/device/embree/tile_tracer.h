#pragma once
// The driver that runs the kernel's stages over a block of pixels: traces the rays of all pixels together, in packets,
// and keeps each pixel's pending rays on a stack, so that every pixel sums its contributions in the kernel's order
// whatever the block or packet size. No shading maths here.

#include "server/device/embree/embree_scene.h"
#include "server/device/embree/tile_arena.h"
#include "server/render/tile.h"

#include <algorithm>

namespace heliograph {

struct TraceOptions {
    uint32_t primaryWidth = 16;    // packet width of camera and shadow rays; 1 = one by one
    uint32_t secondaryWidth = 16;  // of all others
};

template <uint32_t EFFECTS>
class TileTracer {
public:
    using KernelType = kernel_baseline::Kernel<EFFECTS>;
    using Path = typename KernelType::PathState;
    using Surface = typename KernelType::Surface;
    using Shading = typename KernelType::Shading;

    /// Memory of one thread; may be reused by any later tracer of the same type.
    struct Arena {
        Path path[BLOCK_LANES];
        Hit hit[BLOCK_LANES];
        vec3 radiance[BLOCK_LANES];
        uvec2 pixel[BLOCK_LANES];
        std::vector<uint16_t> active;
        PathStacks<Path> stacks;
        std::vector<ShadowQueue> shadows;
        OcclusionQueue occlusion;
        RTCRayHit16 packet;
    };

    TileTracer(const EmbreeScene& scene, const FrameConstants& frame, TraceOptions options, Arena& arena)
        : scene_(scene), options_(options), arena_(arena) {
        kernel_.scene = scene.view();
        kernel_.frame = frame;
    }

    void render(TileResult& result) {
        const Tile& tile = result.tile;
        result.radianceSum.assign(size_t(tile.size.x) * tile.size.y, vec4(0.0f));
        for (uint32_t sample = tile.firstSample; sample < tile.firstSample + tile.sampleCount; sample++)
            for (uint32_t y = 0; y < tile.size.y; y += 32)
                for (uint32_t x = 0; x < tile.size.x; x += 32)
                    renderBlock(result, uvec2(x, y), min2(uvec2(32), tile.size - uvec2(x, y)), sample);
        result.rays = rays_;
    }

private:
    static uvec2 min2(uvec2 a, uvec2 b) { return {std::min(a.x, b.x), std::min(a.y, b.y)}; }

    void renderBlock(TileResult& result, uvec2 corner, uvec2 size, uint32_t sample) {
        uint32_t lanes = placeLanes(result.tile.origin + corner, size);
        sample_ = sample;
        secondary_ = false;
        arena_.stacks.clear(lanes);
        arena_.active.resize(lanes);
        for (uint32_t lane = 0; lane < lanes; lane++) {
            arena_.active[lane] = static_cast<uint16_t>(lane);
            arena_.path[lane] = kernel_.startSample(arena_.pixel[lane], sample);
            arena_.radiance[lane] = vec3(0.0f);
        }
        while (!arena_.active.empty()) {
            traceActive();
            shadeActive();
            popNext(lanes);
            secondary_ = true;
        }
        collect(result, lanes);
    }

    // Pixels in 4x4 groups, so that a packet looks through a square.
    uint32_t placeLanes(uvec2 origin, uvec2 size) {
        uint32_t lanes = 0;
        for (uint32_t y = 0; y < size.y; y += 4)
            for (uint32_t x = 0; x < size.x; x += 4)
                for (uint32_t j = y; j < std::min(y + 4, size.y); j++)
                    for (uint32_t i = x; i < std::min(x + 4, size.x); i++) arena_.pixel[lanes++] = origin + uvec2(i, j);
        return lanes;
    }

    void popNext(uint32_t lanes) {
        arena_.active.clear();
        for (uint32_t lane = 0; lane < lanes; lane++)
            if (arena_.stacks.pop(lane, arena_.path[lane])) arena_.active.push_back(static_cast<uint16_t>(lane));
    }

    TraceMode mode(bool coherent) const {
        return {secondary_ || !coherent ? options_.secondaryWidth : options_.primaryWidth, coherent && !secondary_};
    }

    void traceActive() {
        RTCRayHit16& packet = arena_.packet;
        uint32_t total = static_cast<uint32_t>(arena_.active.size());
        for (uint32_t first = 0; first < total; first += PACKET) {
            uint32_t count = std::min(PACKET, total - first);
            for (uint32_t i = 0; i < count; i++) {
                const Path& path = arena_.path[arena_.active[first + i]];
                setRay(packet.ray, i, path.origin, path.direction, KernelType::FLOAT_MAX);
                if (!secondary_) rays_[RayKind::primary]++;
                else rays_[kernel_.rayKindOf(path.depth) == KernelType::RAY_REFLECTION ? RayKind::reflection
                                                                                         : RayKind::refraction]++;
            }
            traceClosest(scene_.handle(), packet, count, mode(true));
            for (uint32_t i = 0; i < count; i++)
                arena_.hit[arena_.active[first + i]] =
                    EmbreeScene::hitOf(packet.hit.geomID[i], packet.hit.primID[i], packet.hit.instID[0][i]);
        }
    }

    void shadeActive() {
        uint32_t lights = kernel_.frame.lightCount;
        uint32_t total = static_cast<uint32_t>(arena_.active.size());
        // Many lights take the lanes in smaller groups, so that the queues stay small.
        uint32_t group = std::clamp(8192u / std::max(lights, 1u), PACKET, BLOCK_LANES);
        if (arena_.shadows.size() < lights) arena_.shadows.resize(lights);
        for (uint32_t l = 0; l < lights; l++) arena_.shadows[l].reserve(std::min(group, total));
        for (uint32_t first = 0; first < total; first += group) {
            for (uint32_t l = 0; l < lights; l++) arena_.shadows[l].count = 0;
            arena_.occlusion.count = 0;
            for (uint32_t i = first; i < std::min(first + group, total); i++) shadeLane(arena_.active[i]);
            for (uint32_t l = 0; l < lights; l++) traceShadows(arena_.shadows[l]);
            traceOcclusion();
        }
    }

    // The stages of one hit up to its occlusion rays.
    void shadeLane(uint16_t lane) {
        const Path& path = arena_.path[lane];
        vec3& radiance = arena_.radiance[lane];
        if (arena_.hit[lane].instance == NO_INDEX) {
            radiance += kernel_.missRadiance(path);
            return;
        }
        Surface s = kernel_.surfaceAt(path.origin, path.direction, path.coneWidth, path.coneSpread, arena_.hit[lane]);
        Shading m = kernel_.shadingAt(s);
        vec3 wo = -path.direction;
        vec3 throughput = path.throughput * kernel_.mediumTransmittance(path.medium, s);
        radiance += kernel_.emittedRadiance(m, throughput);
        vec3 ambient = kernel_.ambientContribution(m, wo, throughput);
        if (kernel_.needsOcclusion(ambient)) pushOcclusion(lane, path, s, m, ambient);
        else radiance += ambient;
        pushNext(lane, path, s, m, throughput);
        for (uint32_t l = 0; l < kernel_.frame.lightCount; l++) {
            auto shadow = kernel_.lightRay(l, s, m, wo, throughput);
            if (!(kernel_.maxComponent(shadow.contribution) > 0.0f)) continue;
            arena_.shadows[l].push(shadow.ray, lane, shadow.contribution);
        }
    }

    void pushNext(uint16_t lane, const Path& path, const Surface& s, const Shading& m, vec3 throughput) {
        Path reflection, refraction, pass;
        uint32_t next = kernel_.nextRays(path, s, m, throughput, reflection, refraction, pass, arena_.radiance[lane]);
        if (next == 0) return;
        if (next & KernelType::NEXT_REFLECTION) arena_.stacks.push(lane, reflection);
        if (next & KernelType::NEXT_PASS) arena_.stacks.push(lane, pass);
        if (next & KernelType::NEXT_REFRACTION) arena_.stacks.push(lane, refraction);
    }

    void traceShadows(ShadowQueue& queue) {
        bool traced = (EFFECTS & kernel_.frame.effects & EFFECT_SHADOWS) != 0;
        for (uint32_t first = 0; first < queue.count; first += PACKET) {
            uint32_t count = std::min(PACKET, queue.count - first);
            uint32_t blocked = 0;
            uint32_t passed = 0;
            if (traced) {
                blocked = traceOccluded(scene_.handle(), queue.packets[first / PACKET], count, mode(true), passed);
                rays_[RayKind::shadow] += count;
            }
            for (uint32_t i = 0; i < count; i++) {
                if (blocked >> i & 1u) continue;
                vec3 contribution = queue.contributions[first + i];
                if (passed >> i & 1u) contribution *= transmittance(queue.packets[first / PACKET], i);
                arena_.radiance[queue.lanes[first + i]] += contribution;
            }
        }
    }

    // Walks a shadow ray that nothing opaque blocks through its transparent surfaces, nearest first.
    vec3 transmittance(const RTCRay16& rays, uint32_t lane) {
        vec3 origin = rayOrigin(rays, lane);
        vec3 direction = rayDirection(rays, lane);
        float left = rays.tfar[lane];
        vec3 through(1.0f);
        RTCRayHit16 packet;
        for (uint32_t step = 0; step < KernelType::MAX_SHADOW_SURFACES; step++) {
            setRay(packet.ray, 0, origin, direction, left, MASK_TRANSPARENT);
            traceClosest(scene_.handle(), packet, 1, {1, false});
            rays_[RayKind::shadow]++;
            Hit hit = EmbreeScene::hitOf(packet.hit.geomID[0], packet.hit.primID[0], packet.hit.instID[0][0]);
            if (hit.instance == NO_INDEX) return through;
            Surface s = kernel_.surfaceAt(origin, direction, 0.0f, 0.0f, hit);
            through *= kernel_.surfaceTransmittance(s, direction, s.frontFace != 0u ? 0.0f : s.distance);
            if (!(kernel_.maxComponent(through) > 0.0f)) return vec3(0.0f);
            left -= s.distance;
            if (!(left > 0.0f)) return through;
            origin = kernel_.offsetRayOrigin(s.position, -s.geometricNormal);
        }
        return vec3(0.0f);
    }

    void pushOcclusion(uint16_t lane, const Path& path, const Surface& s, const Shading& m, vec3 ambient) {
        OcclusionQueue& queue = arena_.occlusion;
        if (queue.count / PACKET >= queue.groups.size()) queue.groups.emplace_back();
        OcclusionQueue::Group& group = queue.groups[queue.count / PACKET];
        uint32_t i = queue.count % PACKET;
        vec3 origin = kernel_.offsetRayOrigin(s.position, s.geometricNormal);
        vec3 tangent, bitangent;
        kernel_.orthonormalBasis(m.normal, tangent, bitangent);
        for (int axis = 0; axis < 3; axis++) {
            group.origin[axis][i] = origin[axis];
            group.normal[axis][i] = m.normal[axis];
            group.geometricNormal[axis][i] = s.geometricNormal[axis];
            group.tangent[axis][i] = tangent[axis];
            group.bitangent[axis][i] = bitangent[axis];
        }
        group.shift[i] = kernel_.occlusionShift(arena_.pixel[lane], path.salt);
        group.lane[i] = lane;
        group.ambient[i] = ambient;
        queue.count++;
    }

    void traceOcclusion() {
        OcclusionQueue& queue = arena_.occlusion;
        uint32_t samples = kernel_.frame.aoSamples;
        RTCRay16& rays = arena_.packet.ray;
        for (uint32_t first = 0; first < queue.count; first += PACKET) {
            OcclusionQueue::Group& group = queue.groups[first / PACKET];
            uint32_t count = std::min(PACKET, queue.count - first);
            for (uint32_t i = 0; i < PACKET; i++) group.visible[i] = 0;
            for (uint32_t index = 0; index < samples; index++) {
                aimOcclusion(group, kernel_.scene.sobol[kernel_.occlusionNumber(sample_, index)], rays);
                uint32_t passed = 0;
                uint32_t blocked = traceOccluded(scene_.handle(), rays, count, {options_.secondaryWidth, false}, passed);
                for (uint32_t i = 0; i < PACKET; i++) group.visible[i] += 1u - (blocked >> i & 1u);
            }
            rays_[RayKind::ambientOcclusion] += uint64_t(samples) * count;
            for (uint32_t i = 0; i < count; i++)
                arena_.radiance[group.lane[i]] += group.ambient[i] * kernel_.occlusionVisibility(group.visible[i], samples);
        }
    }

    void aimOcclusion(const OcclusionQueue::Group& g, uvec2 point, RTCRay16& rays) {
        float distance = kernel_.frame.aoDistance;
        for (uint32_t i = 0; i < PACKET; i++) {
            vec3 d = kernel_.occlusionDirection(point, g.shift[i], vec3(g.normal[0][i], g.normal[1][i], g.normal[2][i]),
                                                vec3(g.geometricNormal[0][i], g.geometricNormal[1][i], g.geometricNormal[2][i]),
                                                vec3(g.tangent[0][i], g.tangent[1][i], g.tangent[2][i]),
                                                vec3(g.bitangent[0][i], g.bitangent[1][i], g.bitangent[2][i]));
            rays.dir_x[i] = d.x;
            rays.dir_y[i] = d.y;
            rays.dir_z[i] = d.z;
        }
        for (uint32_t i = 0; i < PACKET; i++) {
            rays.org_x[i] = g.origin[0][i];
            rays.org_y[i] = g.origin[1][i];
            rays.org_z[i] = g.origin[2][i];
            rays.tnear[i] = 0.0f;
            rays.time[i] = 0.0f;
            rays.tfar[i] = distance;
            rays.mask[i] = 0xffffffffu;
            rays.id[i] = i;
            rays.flags[i] = 0;
        }
    }

    void collect(TileResult& result, uint32_t lanes) {
        for (uint32_t lane = 0; lane < lanes; lane++) {
            vec3 radiance = arena_.radiance[lane];
            if (!kernel_.isFinite3(radiance)) {
                result.nonfiniteSamples++;
                continue;
            }
            uvec2 at = arena_.pixel[lane] - result.tile.origin;
            float y = kernel_.luminance(radiance);
            result.radianceSum[size_t(at.y) * result.tile.size.x + at.x] += vec4(radiance, y * y);
        }
    }

    const EmbreeScene& scene_;
    TraceOptions options_;
    Arena& arena_;
    KernelType kernel_;
    RayCounts rays_;
    uint32_t sample_ = 0;
    bool secondary_ = false;
};

}  // namespace heliograph

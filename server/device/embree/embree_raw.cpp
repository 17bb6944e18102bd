#include "server/device/embree/embree_raw.h"

#include "server/base/clock.h"
#include "server/device/embree/embree_scene.h"
#include "server/device/embree/flush_denormals.h"
#include "server/film/tile.h"
#include "server/kernel/kernel.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <stdexcept>

namespace heliograph {

/// Sixteen rays, ready to be loaded.
struct alignas(64) BarePacket {
    float origin[3][PACKET];
    float direction[3][PACKET];
    float tMax[PACKET];
    uint32_t count = 0;
};

struct RayList {
    std::vector<BarePacket> packets;
    uint64_t rays = 0;

    void push(vec3 origin, vec3 direction, float tMax) {
        if (packets.empty() || packets.back().count == PACKET) packets.emplace_back();
        BarePacket& p = packets.back();
        for (int axis = 0; axis < 3; axis++) {
            p.origin[axis][p.count] = origin[axis];
            p.direction[axis][p.count] = direction[axis];
        }
        p.tMax[p.count++] = tMax;
        rays++;
    }
    void append(const RayList& other) {
        packets.insert(packets.end(), other.packets.begin(), other.packets.end());
        rays += other.rays;
    }
};

namespace {

using RayKernel = scalar_kernel::Kernel<~uint64_t(0)>;
constexpr uint32_t BLOCK = 32;         // pixels of a block's side; blocks are traced as one task
constexpr uint32_t TASK_PACKETS = 64;  // packets per task, as many as a block has

void load(RTCRay16& rays, const BarePacket& p) {
    for (uint32_t i = 0; i < PACKET; i++)
        setRay(rays, i, vec3(p.origin[0][i], p.origin[1][i], p.origin[2][i]),
               vec3(p.direction[0][i], p.direction[1][i], p.direction[2][i]), p.tMax[i]);
}

/// The rays of one block of pixels.
struct BlockRays {
    RayList primary, shadow, occlusion;
};

/// Visits pixels in the order of the tile driver: 4x4 squares.
template <typename Visit>
void visitPixels(uvec2 origin, uvec2 size, Visit visit) {
    for (uint32_t y = 0; y < size.y; y += 4)
        for (uint32_t x = 0; x < size.x; x += 4)
            for (uint32_t j = y; j < std::min(y + 4, size.y); j++)
                for (uint32_t i = x; i < std::min(x + 4, size.x); i++) visit(origin + uvec2(i, j));
}

struct OcclusionPoint {
    vec3 origin, normal, geometricNormal;
    uint32_t shift;
};

void makeOcclusion(RayKernel& k, const std::vector<OcclusionPoint>& points, RayList& list) {
    for (size_t first = 0; first < points.size(); first += PACKET)
        for (uint32_t index = 0; index < k.frame.aoSamples; index++) {
            list.packets.emplace_back();
            for (size_t i = first; i < std::min(first + PACKET, points.size()); i++) {
                const OcclusionPoint& p = points[i];
                vec3 t, b;
                k.orthonormalBasis(p.normal, t, b);
                list.push(
                    p.origin,
                    k.occlusionDirection(k.sobolPoint(k.occlusionNumber(0, index)), p.shift, p.normal, p.geometricNormal, t, b),
                    k.frame.aoDistance);
            }
        }
}

BlockRays makeBlock(const EmbreeScene& scene, const FrameConstants& frame, uvec2 origin, uvec2 size) {
    RayKernel k;
    k.scene = scene.view();
    k.frame = frame;
    BlockRays rays;
    std::vector<OcclusionPoint> points;
    std::vector<RayList> shadows(frame.lightCount);
    visitPixels(origin, size, [&](uvec2 pixel) {
        auto path = k.startSample(pixel, 0);
        rays.primary.push(path.origin, path.direction, RayKernel::FLOAT_MAX);
        RTCRayHit16 packet;
        setRay(packet.ray, 0, path.origin, path.direction, RayKernel::FLOAT_MAX);
        traceClosest(scene.target(), packet, 1, {1, true});
        Hit hit = EmbreeScene::hitOf(packet.hit.geomID[0], packet.hit.primID[0], packet.hit.instID[0][0]);
        if (hit.instance == NO_INDEX) return;
        auto s = k.surfaceAt(path.origin, path.direction, path.coneWidth, path.coneSpread, hit);
        auto m = k.shadingAt(s);
        k.seenFrom(m, -path.direction);
        for (uint32_t l = 0; l < frame.lightCount; l++) {
            auto ray = k.lightRay(l, s, m, -path.direction, path.throughput);
            if (k.maxComponent(ray.contribution) > 0.0f) shadows[l].push(ray.ray.origin, ray.ray.direction, ray.ray.tMax);
        }
        if (k.needsOcclusion(k.ambientContribution(m, -path.direction, path.throughput)))
            points.push_back({k.offsetRayOrigin(s.position, s.geometricNormal, s.clearance), m.normal, s.geometricNormal,
                              k.occlusionShift(pixel, path.salt)});
    });
    for (const RayList& list : shadows) rays.shadow.append(list);
    makeOcclusion(k, points, rays.occlusion);
    return rays;
}

}  // namespace

struct EmbreeRaw::Data {
    EmbreeHandle<RTCDevice> device{rtcNewDevice("set_affinity=0")};  // before the scene of it
    std::unique_ptr<EmbreeScene> scene;
    uint32_t width = 4;
    RayList primary, shadow, occlusion;
};

EmbreeRaw::EmbreeRaw() : data_(std::make_unique<Data>()) {
    if (!data_->device) throw std::runtime_error("Embree could not start");
    data_->width = nativePacketWidth(data_->device.get());
}

EmbreeRaw::~EmbreeRaw() = default;

void EmbreeRaw::prepare(std::shared_ptr<const Scene> scene, const FrameRequest& request) {
    const Settings& settings = request.settings;
    data_->scene = std::make_unique<EmbreeScene>(data_->device.get(), scene, settings.bvhQuality, settings.robust, Progress{});
    FrameConstants frame = frameConstants(*scene, request);
    uvec2 blocks = (request.resolution + BLOCK - 1u) / BLOCK;
    std::vector<BlockRays> made(size_t(blocks.x) * blocks.y);
    tbb::parallel_for(size_t(0), made.size(), [&](size_t i) {
        uvec2 origin = uvec2(i % blocks.x, i / blocks.x) * BLOCK;
        made[i] = makeBlock(*data_->scene, frame, origin, glm::min(uvec2(BLOCK), request.resolution - origin));
    });
    data_->primary = data_->shadow = data_->occlusion = RayList{};
    for (BlockRays& block : made) {
        data_->primary.append(block.primary);
        data_->shadow.append(block.shadow);
        data_->occlusion.append(block.occlusion);
        block = BlockRays{};
    }
}

BareTime EmbreeRaw::trace(RayKind kind) {
    const RayList& list = kind == RayKind::primary  ? data_->primary
                          : kind == RayKind::shadow ? data_->shadow
                                                    : data_->occlusion;
    bool closest = kind == RayKind::primary;
    bool coherent = closest ? data_->scene->coherentPrimary() : kind == RayKind::shadow && data_->scene->coherentShadows();
    TraceMode mode{data_->width, coherent};
    const TraceTarget scene = data_->scene->target();
    std::atomic<uint64_t> found{0};
    double cpu = processCpuSeconds();
    double wall = wallSeconds();
    size_t tasks = (list.packets.size() + TASK_PACKETS - 1) / TASK_PACKETS;
    tbb::parallel_for(size_t(0), tasks, [&](size_t task) {
        const FlushDenormals flush;
        uint64_t hits = 0;
        for (size_t i = task * TASK_PACKETS; i < std::min((task + 1) * TASK_PACKETS, list.packets.size()); i++) {
            const BarePacket& bare = list.packets[i];
            RTCRayHit16 packet;
            load(packet.ray, bare);
            if (closest) {
                traceClosest(scene, packet, bare.count, mode);
                for (uint32_t r = 0; r < bare.count; r++) hits += packet.hit.geomID[r] != RTC_INVALID_GEOMETRY_ID;
            } else {
                uint32_t passed;
                hits += static_cast<uint64_t>(__builtin_popcount(traceOccluded(scene, packet.ray, bare.count, mode, passed)));
            }
        }
        found += hits;
    });
    BareTime time;
    time.wallMs = 1e3 * (wallSeconds() - wall);
    time.coreMs = 1e3 * (processCpuSeconds() - cpu);
    time.rays = list.rays;
    if (found.load() > list.rays) throw std::logic_error("more hits than rays");
    return time;
}

}  // namespace heliograph

// Bare Embree, one ray at a time, and the Embree device's scene and packets.

#include "server/device/embree/embree_scene.h"
#include "server/device/embree/flush_denormals.h"
#include "tests/hard/tracer.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace heliograph::hard {

namespace {

RTCDevice sharedDevice() {
    static const EmbreeHandle<RTCDevice> device(rtcNewDevice("threads=1"));
    if (!device) throw std::runtime_error("Embree could not start");
    return device.get();
}

struct Collector {
    RTCIntersectContext rtc;
    std::vector<Met>* met;
};

void collect(const RTCFilterFunctionNArguments* arguments) {
    auto* collector = reinterpret_cast<Collector*>(arguments->context);
    const uint32_t triangle = RTCHitN_primID(arguments->hit, arguments->N, 0);
    collector->met->push_back({triangle, RTCRayN_tfar(arguments->ray, arguments->N, 0)});
    arguments->valid[0] = 0;
}

RTCRayHit packed(const Ray& ray) {
    RTCRayHit r{};
    r.ray = {ray.origin.x,
             ray.origin.y,
             ray.origin.z,
             0.0f,
             ray.direction.x,
             ray.direction.y,
             ray.direction.z,
             0.0f,
             ray.tMax,
             0xffffffffu,
             0,
             0};
    r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

/// Over others this build of Embree ends the process.
bool bearable(const Ray& ray) {
    const vec3 most = glm::max(glm::abs(ray.origin), glm::abs(ray.direction));
    return std::max({most.x, most.y, most.z}) <= 1e18f && !std::isnan(ray.tMax);
}

class BareEmbree : public Tracer {
public:
    BareEmbree(const World& world, bool robust) : world_(world), robust_(robust), scene_(rtcNewScene(sharedDevice())) {
        const int flags = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION | (robust ? RTC_SCENE_FLAG_ROBUST : 0);
        rtcSetSceneFlags(scene_.get(), static_cast<RTCSceneFlags>(flags));
        const EmbreeHandle<RTCGeometry> geometry(rtcNewGeometry(sharedDevice(), RTC_GEOMETRY_TYPE_TRIANGLE));
        const MeshData& mesh = world.mesh();
        void* corners = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3),
                                                mesh.positions.size());
        void* indices = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3),
                                                mesh.indices.size());
        std::memcpy(corners, mesh.positions.data(), mesh.positions.size() * sizeof(vec3));
        std::memcpy(indices, mesh.indices.data(), mesh.indices.size() * sizeof(uvec3));
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(scene_.get(), geometry.get());
        rtcCommitScene(scene_.get());
    }
    const char* column() const override { return robust_ ? column::ROBUST : column::FAST; }

    void trace(std::span<const Ray> rays, std::vector<Met>& met) override {
        met.assign(rays.size(), {});
        inBlocks(rays.size(), [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; i++) {
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                if (!bearable(rays[i])) continue;
                RTCRayHit r = packed(rays[i]);
                rtcIntersect1(scene_.get(), &context, &r);
                if (r.hit.geomID != RTC_INVALID_GEOMETRY_ID) met[i] = {r.hit.primID, r.ray.tfar};
            }
        });
    }

    bool traceAll(std::span<const Ray> rays, std::vector<std::vector<Met>>& met) override {
        met.assign(rays.size(), {});
        inBlocks(rays.size(), [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; i++) {
                Collector collector{{}, &met[i]};
                rtcInitIntersectContext(&collector.rtc);
                collector.rtc.filter = collect;
                RTCRayHit r = packed(rays[i]);
                rtcIntersect1(scene_.get(), &collector.rtc, &r);
            }
        });
        return true;
    }

    Ray leave(const Ray& ray, const Met& met, vec3 direction) const override {
        return leaveByKernel(world_, ray, met, direction);
    }
    vec3 point(const Ray& ray, const Met& met) const override { return ray.origin + ray.direction * met.t; }

private:
    const World& world_;
    bool robust_;
    EmbreeHandle<RTCScene> scene_;
};

class EmbreePackets : public Tracer {
public:
    explicit EmbreePackets(const World& world)
        : world_(world), scene_(sharedDevice(), world.scene(), 1, true, {}), width_(nativePacketWidth(sharedDevice())) {}
    const char* column() const override { return column::EMBREE; }

    void trace(std::span<const Ray> rays, std::vector<Met>& met) override {
        met.assign(rays.size(), {});
        inBlocks((rays.size() + PACKET - 1) / PACKET, [&](size_t begin, size_t end) {
            const FlushDenormals flush;  // as the device's threads have it
            for (size_t block = begin; block < end; block++) packet(rays, block * PACKET, met);
        });
    }

    Ray leave(const Ray& ray, const Met& met, vec3 direction) const override {
        return leaveByKernel(world_, ray, met, direction);
    }
    vec3 point(const Ray& ray, const Met& met) const override { return world_.surface(ray, met).position; }

private:
    void packet(std::span<const Ray> rays, size_t first, std::vector<Met>& met) const {
        RTCRayHit16 packet;
        const auto count = static_cast<uint32_t>(std::min<size_t>(PACKET, rays.size() - first));
        for (uint32_t i = 0; i < count; i++)
            setRay(packet.ray, i, rays[first + i].origin, rays[first + i].direction, rays[first + i].tMax);
        traceClosest(scene_.target(), packet, count, {width_, false});
        for (uint32_t i = 0; i < count; i++) {
            Met& m = met[first + i];
            if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
            m.triangle = packet.hit.primID[i];
            m.t = world_.surface(rays[first + i], m).distance;
        }
    }

    const World& world_;
    EmbreeScene scene_;
    uint32_t width_;
};

}  // namespace

std::unique_ptr<Tracer> bareEmbree(const World& world, bool robust) { return std::make_unique<BareEmbree>(world, robust); }
std::unique_ptr<Tracer> embreePackets(const World& world) { return std::make_unique<EmbreePackets>(world); }

}  // namespace heliograph::hard

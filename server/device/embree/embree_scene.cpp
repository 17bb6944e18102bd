#include "server/device/embree/embree_scene.h"

#include "server/kernel/kernel.h"
#include "server/scene/shape.h"

#include <exception>
#include <limits>
#include <mutex>
#include <stdexcept>

namespace heliograph {

namespace {

// The alpha test alone: what the filters need of the kernel.
constexpr uint64_t ALPHA_EFFECTS =
    EFFECT_TEXTURES | EFFECT_VERTEX_COLORS | EFFECT_INSTANCING | EFFECT_SECOND_UV | EFFECT_SHAPES;
using AlphaKernel = scalar_kernel::Kernel<ALPHA_EFFECTS>;

RTCBuildQuality buildQuality(uint32_t quality) {
    if (quality == 0) return RTC_BUILD_QUALITY_LOW;
    return quality == 1 ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH;
}

uint32_t maskOf(uint32_t opacity) {
    if (opacity == OPACITY_MASKED) return MASK_MASKED;
    return opacity == OPACITY_TRANSPARENT ? MASK_TRANSPARENT : MASK_OPAQUE;
}

// True if the hit is in the hole of a cut-out. The point is recomputed from the ray as it was sent, so that the answer
// does not depend on the traversal.
bool isHole(const EmbreeScene& scene, const RTCIntersectContext* traced, uint32_t lane, Hit hit) {
    const auto* context = reinterpret_cast<const TraceContext*>(traced);
    AlphaKernel kernel;
    kernel.scene = scene.view();
    kernel.frame.effects = static_cast<uint32_t>(ALPHA_EFFECTS);
    kernel.frame.layers = ALPHA_EFFECTS >> 32;
    auto surface = kernel.surfaceAt(rayOrigin(*context->rays, lane), rayDirection(*context->rays, lane), 0.0f, 0.0f, hit);
    return kernel.isCutOut(surface);
}

bool hitsHole(const RTCFilterFunctionNArguments* args, uint32_t i) {
    const Hit hit = EmbreeScene::hitOf(RTCHitN_geomID(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i),
                                       RTCHitN_instID(args->hit, args->N, i, 0));
    return isHole(*static_cast<const EmbreeScene*>(args->geometryUserPtr), args->context, RTCRayN_id(args->ray, args->N, i),
                  hit);
}

void filterMasked(const RTCFilterFunctionNArguments* args) {
    for (uint32_t i = 0; i < args->N; i++)
        if (args->valid[i] == -1 && hitsHole(args, i)) args->valid[i] = 0;
}

// Occlusion rays pass transparent surfaces; which ones is found out later, in order, by a walk. So it does not matter if
// a triangle is offered twice, as spatial splits may do.
void filterTransparent(const RTCFilterFunctionNArguments* args) {
    auto* context = reinterpret_cast<TraceContext*>(args->context);
    for (uint32_t i = 0; i < args->N; i++) {
        if (args->valid[i] != -1) continue;
        args->valid[i] = 0;
        context->passedTransparent |= 1u << RTCRayN_id(args->ray, args->N, i);
    }
}

void boundShape(const RTCBoundsFunctionArguments* args) {
    const auto* shape = static_cast<const ShapeOfScene*>(args->geometryUserPtr);
    const Bounds box = shapeBounds(shape->scene->scene().instances[shape->instance]);
    RTCBounds& out = *args->bounds_o;
    out.lower_x = box.low.x, out.lower_y = box.low.y, out.lower_z = box.low.z;
    out.upper_x = box.high.x, out.upper_y = box.high.y, out.upper_z = box.high.z;
}

/// A ray of a packet, and what of a shape may stop it.
struct ShapeTest {
    const ShapeOfScene& shape;
    const Instance& instance;
    AlphaKernel kernel;

    explicit ShapeTest(const void* data)
        : shape(*static_cast<const ShapeOfScene*>(data)), instance(shape.scene->scene().instances[shape.instance]) {
        kernel.scene = shape.scene->view();
    }

    /// Which end of the shape the ray meets between its own, the nearest that is no hole; 2: none. `t`: how far that is.
    uint32_t metEnd(const RTCIntersectContext* context, RTCRayN* ray, uint32_t n, uint32_t i, float& t) {
        const vec3 origin(RTCRayN_org_x(ray, n, i), RTCRayN_org_y(ray, n, i), RTCRayN_org_z(ray, n, i));
        const vec3 direction(RTCRayN_dir_x(ray, n, i), RTCRayN_dir_y(ray, n, i), RTCRayN_dir_z(ray, n, i));
        const vec2 ends = kernel.shapeDistances(shape.instance, origin, direction);
        for (uint32_t end = 0; end < 2; end++) {
            t = end == 0 ? ends.x : ends.y;
            if (!(t > 0.0f && t < RTCRayN_tfar(ray, n, i))) continue;
            const Hit hit{shape.instance, end};
            if (shapeOpacityOf(instance) == OPACITY_MASKED && isHole(*shape.scene, context, RTCRayN_id(ray, n, i), hit))
                continue;
            return end;
        }
        return 2;
    }
};

void intersectShape(const RTCIntersectFunctionNArguments* args) {
    ShapeTest test(args->geometryUserPtr);
    RTCRayN* ray = RTCRayHitN_RayN(args->rayhit, args->N);
    RTCHitN* hit = RTCRayHitN_HitN(args->rayhit, args->N);
    for (uint32_t i = 0; i < args->N; i++) {
        if (args->valid[i] != -1) continue;
        float t;
        const uint32_t end = test.metEnd(args->context, ray, args->N, i, t);
        if (end == 2) continue;
        RTCRayN_tfar(ray, args->N, i) = t;
        RTCHitN_geomID(hit, args->N, i) = test.shape.instance;
        RTCHitN_primID(hit, args->N, i) = end;
        RTCHitN_instID(hit, args->N, i, 0) = RTC_INVALID_GEOMETRY_ID;
    }
}

void occludeShape(const RTCOccludedFunctionNArguments* args) {
    ShapeTest test(args->geometryUserPtr);
    auto* context = reinterpret_cast<TraceContext*>(args->context);
    for (uint32_t i = 0; i < args->N; i++) {
        float t;
        if (args->valid[i] != -1 || test.metEnd(args->context, args->ray, args->N, i, t) == 2) continue;
        if (shapeOpacityOf(test.instance) == OPACITY_TRANSPARENT)
            context->passedTransparent |= 1u << RTCRayN_id(args->ray, args->N, i);
        else RTCRayN_tfar(args->ray, args->N, i) = -std::numeric_limits<float>::infinity();
    }
}

void check(RTCError error, const char* what) {
    if (error != RTC_ERROR_NONE)
        throw std::runtime_error(std::string("Embree could not ") + what + " (error " + std::to_string(error) + ")");
}

bool hasPlacedInstance(const Scene& scene) {
    for (const Instance& instance : scene.instances)
        if ((instance.flags & INSTANCE_IDENTITY) == 0) return true;
    return false;
}

/// Carries what a caller's progress throws past Embree, which would swallow it.
class BuildWatch {
public:
    explicit BuildWatch(const Progress& progress) : progress_(progress) {}

    /// For Embree, from any of its threads; false ends the build.
    static bool goOn(void* self, double share) { return static_cast<BuildWatch*>(self)->report(share); }
    void rethrow() const {
        if (thrown_) std::rethrow_exception(thrown_);
    }

private:
    bool report(double share) {
        std::lock_guard lock(mutex_);
        try {
            if (!thrown_) heliograph::report(progress_, "building the acceleration structure", share);
        } catch (...) {
            thrown_ = std::current_exception();
        }
        return !thrown_;
    }

    const Progress& progress_;
    std::mutex mutex_;
    std::exception_ptr thrown_;
};

// Builds the tree of a scene.
void commit(RTCDevice device, RTCScene scene, const Progress& progress) {
    BuildWatch watch(progress);
    if (progress) rtcSetSceneProgressMonitorFunction(scene, BuildWatch::goOn, &watch);
    rtcCommitScene(scene);
    rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
    const RTCError error = rtcGetDeviceError(device);
    watch.rethrow();
    check(error, "build the acceleration structure");
}

}  // namespace

EmbreeScene::EmbreeScene(RTCDevice device, std::shared_ptr<const Scene> scene, uint32_t quality, bool robust,
                         const Progress& progress)
    : scene_(std::move(scene)), view_(sceneView(*scene_)), rayReach_(scene_->rayReach()) {
    meshScenes_.resize(scene_->meshes.size());
    for (const Mesh& mesh : scene_->meshes) {
        coherentPrimary_ = coherentPrimary_ && mesh.opacity != OPACITY_MASKED;
        coherentShadows_ = coherentShadows_ && mesh.opacity == OPACITY_OPAQUE;
    }
    if (nativePacketWidth(device) == PACKET && hasPlacedInstance(*scene_)) coherentPrimary_ = coherentShadows_ = false;
    RTCSceneFlags flags = robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE;
    root_.reset(rtcNewScene(device));
    rtcSetSceneFlags(root_.get(), flags);
    rtcSetSceneBuildQuality(root_.get(), buildQuality(quality));
    // Meshes are small beside the whole: the share stays 0, but the caller may end it there.
    const Progress ofMesh = [&](const std::string& what, double) { report(progress, what, 0.0); };
    for (uint32_t i = 0; i < scene_->instances.size(); i++) attachInstance(device, i, buildQuality(quality), flags, ofMesh);
    commit(device, root_.get(), progress);
}

DepthAnswer EmbreeScene::depthAlong(const ViewRay& ray) const {
    const double length = glm::length(ray.direction);
    alignas(64) RTCRayHit16 packet;
    setRay(packet.ray, 0, vec3(ray.origin), vec3(ray.direction / length), std::numeric_limits<float>::infinity());
    traceClosest(target(), packet, 1, {1, false});
    if (packet.hit.geomID[0] == RTC_INVALID_GEOMETRY_ID) return {true, std::nullopt};
    const Hit hit = hitOf(packet.hit.geomID[0], packet.hit.primID[0], packet.hit.instID[0][0]);
    return {true, static_cast<double>(packet.ray.tfar[0]) / length, hit.instance, hit.primitive};
}

EmbreeHandle<RTCGeometry> EmbreeScene::makeTriangles(RTCDevice device, const Mesh& mesh) {
    EmbreeHandle<RTCGeometry> handle(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
    RTCGeometry geometry = handle.get();
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, scene_->positions.data(), 0,
                               sizeof(vec4), scene_->positions.size() - 1);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               scene_->triangles.data() + mesh.firstTriangle, 0, sizeof(uvec4), mesh.triangleCount);
    rtcSetGeometryMask(geometry, maskOf(mesh.opacity));
    rtcSetGeometryUserData(geometry, this);
    if (mesh.opacity == OPACITY_MASKED) {
        rtcSetGeometryIntersectFilterFunction(geometry, filterMasked);
        rtcSetGeometryOccludedFilterFunction(geometry, filterMasked);
    } else if (mesh.opacity == OPACITY_TRANSPARENT) {
        rtcSetGeometryOccludedFilterFunction(geometry, filterTransparent);
    }
    rtcCommitGeometry(geometry);
    return handle;
}

EmbreeHandle<RTCGeometry> EmbreeScene::makeShape(RTCDevice device, uint32_t index) {
    EmbreeHandle<RTCGeometry> geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER));
    shapes_.push_back(std::make_unique<ShapeOfScene>(ShapeOfScene{this, index}));
    rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
    rtcSetGeometryUserData(geometry.get(), shapes_.back().get());
    rtcSetGeometryBoundsFunction(geometry.get(), boundShape, nullptr);
    rtcSetGeometryIntersectFunction(geometry.get(), intersectShape);
    rtcSetGeometryOccludedFunction(geometry.get(), occludeShape);
    rtcSetGeometryMask(geometry.get(), maskOf(shapeOpacityOf(scene_->instances[index])));
    rtcCommitGeometry(geometry.get());
    return geometry;
}

void EmbreeScene::attachInstance(RTCDevice device, uint32_t index, RTCBuildQuality quality, RTCSceneFlags flags,
                                 const Progress& progress) {
    const Instance& instance = scene_->instances[index];
    const Mesh& mesh = scene_->meshes[instance.mesh];
    if (mesh.triangleCount == 0) return;
    EmbreeHandle<RTCGeometry> geometry;
    if (isShape(instance)) {
        geometry = makeShape(device, index);
    } else if (instance.flags & INSTANCE_IDENTITY) {
        geometry = makeTriangles(device, mesh);
    } else {
        EmbreeHandle<RTCScene>& meshScene = meshScenes_[instance.mesh];
        if (!meshScene) {
            meshScene.reset(rtcNewScene(device));
            rtcSetSceneFlags(meshScene.get(), flags);
            rtcSetSceneBuildQuality(meshScene.get(), quality);
            rtcAttachGeometry(meshScene.get(), makeTriangles(device, mesh).get());
            commit(device, meshScene.get(), progress);
        }
        geometry.reset(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
        rtcSetGeometryInstancedScene(geometry.get(), meshScene.get());
        rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, &instance.toWorld0);
        rtcSetGeometryMask(geometry.get(), maskOf(mesh.opacity));
        rtcCommitGeometry(geometry.get());
    }
    rtcAttachGeometryByID(root_.get(), geometry.get(), index);
    check(rtcGetDeviceError(device), "take a mesh");
}

}  // namespace heliograph

#pragma once
// A scene as Embree holds it: one geometry per placed mesh, instances where a mesh stands in several places, vertex and
// index buffers shared with the scene, filter functions only where a surface is not opaque.

#include "server/base/progress.h"
#include "server/device/device.h"
#include "server/device/embree/ray_packet.h"
#include "server/request/camera.h"
#include "server/scene/kernel_tables.h"

#include <memory>
#include <optional>
#include <type_traits>

namespace heliograph {

/// Ray masks by opacity class, so that a ray can look for one class alone.
constexpr uint32_t MASK_OPAQUE = 1;
constexpr uint32_t MASK_MASKED = 2;
constexpr uint32_t MASK_TRANSPARENT = 4;

struct EmbreeRelease {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
template <typename T>
using EmbreeHandle = std::unique_ptr<std::remove_pointer_t<T>, EmbreeRelease>;

class EmbreeScene;

/// What Embree hands back to the tests of an analytic shape: they see rays as the world has them.
struct ShapeOfScene {
    const EmbreeScene* scene = nullptr;
    uint32_t instance = 0;
};

class EmbreeScene {
public:
    /// Builds the tree. quality: 0 low, 1 medium, 2 high. Throws std::runtime_error when Embree refuses, and what
    /// `progress` throws.
    EmbreeScene(RTCDevice device, std::shared_ptr<const Scene> scene, uint32_t quality, bool robust, const Progress& progress);
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    TraceTarget target() const { return {root_.get(), rayReach_, nullptr}; }
    const Scene& scene() const { return *scene_; }
    const SceneView& view() const { return view_; }

    /// Whether packets of camera (shadow) rays may be traced as coherent. Not where a filter function may reject their
    /// hits, and not 16 wide where there are placed instances: Debian 12's Embree 3.13.5 may not end then. (Its AVX-512
    /// traversal of instances stores 16 bits of a lane mask and reads 64: it ends if the stack happens to hold zeros.)
    bool coherentPrimary() const { return coherentPrimary_; }
    bool coherentShadows() const { return coherentShadows_; }

    /// The nearest surface; holes of cut-outs are looked through.
    DepthAnswer depthAlong(const ViewRay& ray) const;

    /// The kernel's hit from Embree's: only ids are taken.
    static Hit hitOf(uint32_t geometry, uint32_t primitive, uint32_t instance) {
        Hit hit;
        hit.instance = instance != RTC_INVALID_GEOMETRY_ID ? instance : geometry;
        hit.primitive = primitive;
        return hit;
    }

private:
    EmbreeHandle<RTCGeometry> makeTriangles(RTCDevice device, const Mesh& mesh);
    EmbreeHandle<RTCGeometry> makeShape(RTCDevice device, uint32_t index);
    void attachInstance(RTCDevice device, uint32_t index, RTCBuildQuality quality, RTCSceneFlags flags,
                        const Progress& progress);

    std::shared_ptr<const Scene> scene_;
    SceneView view_;
    float rayReach_;
    EmbreeHandle<RTCScene> root_;
    bool coherentPrimary_ = true;
    bool coherentShadows_ = true;
    std::vector<std::unique_ptr<ShapeOfScene>> shapes_;
    std::vector<EmbreeHandle<RTCScene>> meshScenes_;  // one per mesh that is instanced, else null
};

}  // namespace heliograph

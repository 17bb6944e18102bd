#pragma once
// Who shoots rays in the catalogue: one interface for the naive baseline, bare Embree, the kernel's own traversal as C++, the
// Embree device's packets and the Vulkan device's traversal. A world is one mesh; all tracers of it hold the same floats.

#include "server/kernel/kernel.h"
#include "server/scene/build/scene_builder.h"
#include "tests/hard/catalogue.h"
#include "tests/kernel/kernel_access.h"

#include <functional>
#include <memory>
#include <span>

namespace heliograph::hard {

/// What a ray met: triangle of the mesh, and how far in units of the ray's direction.
struct Met {
    uint32_t triangle = NO_INDEX;
    float t = 0.0f;
    bool hit() const { return triangle != NO_INDEX; }
};

inline Ray makeRay(vec3 origin, vec3 direction, float tMax = 3.402823466e38f) {
    Ray ray{};
    ray.origin = origin;
    ray.direction = direction;
    ray.tMax = tMax;
    return ray;
}

class Tracer {
public:
    virtual ~Tracer() = default;
    virtual const char* column() const = 0;
    /// Nearest hits.
    virtual void trace(std::span<const Ray> rays, std::vector<Met>& met) = 0;
    /// All triangles on the way of each ray, in any order; false where this tracer has no such answer.
    virtual bool traceAll(std::span<const Ray> rays, std::vector<std::vector<Met>>& met) {
        return static_cast<void>(rays), static_cast<void>(met), false;
    }
    /// Where a path that arrived by `ray` goes on from what it met, towards `direction`.
    virtual Ray leave(const Ray& ray, const Met& met, vec3 direction) const = 0;
    /// The point that was met.
    virtual vec3 point(const Ray& ray, const Met& met) const = 0;
};

/// A mesh, and the scene that our builder makes of it.
class World {
public:
    explicit World(MeshData mesh);
    /// An analytic shape in the place of the mesh: Met::triangle is 0 where a ray enters it and 1 where it leaves.
    World(ShapeForm form, const mat4& toWorld);

    /// False if the builder refused the mesh, with a warning; then only the naive tracer and bare Embree have it.
    bool taken() const { return scene_->instances.size() == 1; }
    const MeshData& mesh() const { return mesh_; }
    const std::shared_ptr<const Scene>& scene() const { return scene_; }
    test::EveryKernel& kernel() const { return kernel_; }
    /// What our shading makes of a hit.
    test::EveryKernel::Surface surface(const Ray& ray, const Met& met) const;

private:
    void take(SceneBuilder& builder);

    MeshData mesh_;
    std::shared_ptr<const Scene> scene_;
    mutable test::EveryKernel kernel_;  // its functions change nothing, but the kernel's language has no word for that
};

std::unique_ptr<Tracer> naiveTracer(const World& world);
std::unique_ptr<Tracer> bareEmbree(const World& world, bool robust);
std::unique_ptr<Tracer> embreePackets(const World& world);
/// `width` of its tree: 2 as GPUs have it, 4 as CPU-type Vulkan devices have it.
std::unique_ptr<Tracer> ownTracer(const World& world, uint32_t width);
/// Null where no Vulkan device was asked for.
std::unique_ptr<Tracer> vulkanRays(const World& world, const std::string& device);

/// How the product's paths go on: from the kernel's point, by its clearance.
Ray leaveByKernel(const World& world, const Ray& ray, const Met& met, vec3 direction);

/// All of them, the naive one first. If the plan names a ray, prints what each answers to it.
std::vector<std::unique_ptr<Tracer>> tracersOf(const World& world, const Run& run);

/// Those of the product: own traversal with either tree, and the devices. Of shapes there are no others.
std::vector<std::unique_ptr<Tracer>> ownTracersOf(const World& world, const Run& run);

/// How to shoot that ray again.
std::string replayOf(const std::string& name, const Ray& ray);

/// Calls `work` for blocks of [0, count) on all cores.
void inBlocks(size_t count, const std::function<void(size_t begin, size_t end)>& work);

}  // namespace heliograph::hard

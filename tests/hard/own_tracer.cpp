// The Vulkan devices' traversal (shaders/vulkan/bvh.glsl, ray_triangle.glsl) as C++, on the same trees: of two float boxes a
// node, as GPUs have, and of four boxes of bytes, as CPU-type devices have.

#include "server/device/vulkan/tree/bvh_builder.h"
#include "server/scene/kernel_tables.h"
#include "tests/hard/glsl.h"
#include "tests/hard/tracer.h"

#include <stdexcept>

namespace heliograph::hard {

namespace {

using glm::abs;
using glm::cross;
using glm::dot;
using glm::floatBitsToUint;
using glm::lessThanEqual;
using glm::max;
using glm::min;
using glm::uintBitsToFloat;

constexpr uint32_t STACK = 256;

#define SELECT(condition, yes, no) ((condition) ? (yes) : (no))
#define INOUT(T) T&
#define OUT(T) T&
#define HAS(effect) (((effect) & (EFFECT_INSTANCING | EFFECT_ALPHA_MASK)) != 0u)
#define HAS_LAYER(effect) (((effect)&EFFECT_SHAPES) != 0u)
#define INSTANCE(i, field) scene.instances[i].field
#define BVH_NODE(i) uvec4(tree.nodes.data[i])
#define BVH_TRIANGLE(i) uvec4(tree.triangles.data[i])
#define BVH_STACK STACK
#define BVH_HOLE(hit) collect(hit, t)
#define RAY_REACH 3.402823466e38f
#define xyz xyz_()
#define xxyy xxyy_()
#define zzzz zzzz_()

#define OWN_TREE Tree2
#define BVH_WIDTH 2
#include "tests/hard/own_tree.inc"
#undef OWN_TREE
#undef BVH_WIDTH
#undef BVH_NEXT
#undef BVH_DESCEND
#define OWN_TREE Tree4
#define BVH_WIDTH 4
#include "tests/hard/own_tree.inc"
#undef xyz
#undef xxyy
#undef zzzz

template <typename Tree>
class OwnTracer : public Tracer {
public:
    OwnTracer(const World& world, uint32_t width) : world_(world), bvh_(buildBvh(*world.scene(), {width, 3, 1})) {
        if (bvh_.stackDepth > STACK) throw std::logic_error("the catalogue's stack is too small for this tree");
    }
    const char* column() const override { return column::OWN; }

    void trace(std::span<const Ray> rays, std::vector<Met>& met) override {
        met.assign(rays.size(), {});
        inBlocks(rays.size(), [&](size_t begin, size_t end) {
            Tree tree{bvh_, *world_.scene()};
            tree.kernel.scene = sceneView(*world_.scene());
            for (size_t i = begin; i < end; i++) {
                glsl::Hit hit;
                tree.traverse(rays[i].origin, rays[i].direction, rays[i].tMax, tree.TRACE_CLOSEST, hit);
                met[i].triangle = hit.instance == NO_INDEX ? NO_INDEX : hit.primitive;
                if (met[i].hit()) met[i].t = world_.surface(rays[i], met[i]).distance;
            }
        });
    }

    bool traceAll(std::span<const Ray> rays, std::vector<std::vector<Met>>& met) override {
        met.assign(rays.size(), {});
        inBlocks(rays.size(), [&](size_t begin, size_t end) {
            Tree tree{bvh_, *world_.scene()};
            tree.kernel.scene = sceneView(*world_.scene());
            for (size_t i = begin; i < end; i++) {
                glsl::Hit hit;
                tree.collected = &met[i];
                tree.traverse(rays[i].origin, rays[i].direction, rays[i].tMax, tree.TRACE_CLOSEST, hit);
            }
        });
        return true;
    }

    Ray leave(const Ray& ray, const Met& met, vec3 direction) const override {
        return leaveByKernel(world_, ray, met, direction);
    }
    vec3 point(const Ray& ray, const Met& met) const override { return world_.surface(ray, met).position; }

private:
    const World& world_;
    Bvh bvh_;
};

}  // namespace

std::unique_ptr<Tracer> ownTracer(const World& world, uint32_t width) {
    if (width == 2) return std::make_unique<OwnTracer<Tree2>>(world, width);
    return std::make_unique<OwnTracer<Tree4>>(world, width);
}

}  // namespace heliograph::hard

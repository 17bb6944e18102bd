#include "server/device/vulkan/tree/bvh_tree.h"
#include "server/scene/scene.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace heliograph {

namespace {

constexpr uint32_t PARALLEL_DEPTH = 8;  // subtrees below this level are done by one thread

struct Child {
    TreeNode* node;
    Box box;
};

/// Children of a node of the layout: those of the binary node; for 4, the largest inner ones are opened.
struct Children {
    Child at[4];
    uint32_t count = 2;

    Children(TreeNode* node, uint32_t width) {
        for (int i = 0; i < 2; i++) at[i] = {node->child[i], node->bounds[i]};
        while (count < width) {
            int widest = -1;
            for (uint32_t i = 0; i < count; i++)
                if (!at[i].node->isLeaf() && (widest < 0 || at[i].box.halfArea() > at[widest].box.halfArea()))
                    widest = static_cast<int>(i);
            if (widest < 0) return;
            TreeNode* opened = at[widest].node;
            at[widest] = {opened->child[0], opened->bounds[0]};
            at[count++] = {opened->child[1], opened->bounds[1]};
        }
    }
};

template <typename Visit>
void visitAll(const Children& children, uint32_t level, const Visit& visit) {
    if (level >= PARALLEL_DEPTH) {
        for (uint32_t i = 0; i < children.count; i++) visit(i);
        return;
    }
    auto run = [&](uint32_t i) {
        if (i < children.count) visit(i);
    };
    tbb::parallel_invoke([&] { run(0); }, [&] { run(1); }, [&] { run(2); }, [&] { run(3); });
}

void countTree(TreeNode* node, uint32_t width, uint32_t level) {
    if (node->isLeaf()) {
        node->triangles = node->isInstance() ? 0 : node->count;
        return;
    }
    Children children(node, width);
    visitAll(children, level, [&](uint32_t i) { countTree(children.at[i].node, width, level + 1); });
    node->nodes = 1;
    for (uint32_t i = 0; i < children.count; i++) {
        const TreeNode& child = *children.at[i].node;
        node->nodes += child.nodes;
        node->triangles += child.triangles;
        node->depth = std::max(node->depth, child.depth);
    }
    node->depth += 1;
}

/// 255 steps of a power of two over an interval, from a float origin. Values are rounded outwards, and by a hundredth of a
/// step more, which is far above what the traversal's arithmetic can lose.
struct Grid {
    float origin;
    int exponent;
    double step;

    Grid(float low, float high) {
        double extent = std::max<double>({1.05 * (double(high) - low), 4e-7 * std::abs(double(low)), 1e-30});
        exponent = std::clamp(static_cast<int>(std::ceil(std::log2(extent / 254.0))), -126, 120);
        step = std::ldexp(1.0, exponent);
        origin = std::min(static_cast<float>(low - 0.02 * step), std::nextafter(low, -3e38f));
    }
    uint32_t below(float x) const { return clamped(std::floor((double(x) - origin) / step - 0.01)); }
    uint32_t above(float x) const { return clamped(std::ceil((double(x) - origin) / step + 0.01)); }
    static uint32_t clamped(double x) { return static_cast<uint32_t>(std::clamp(x, 0.0, 255.0)); }
};

class Emitter {
public:
    Emitter(const Scene& scene, uint32_t mesh, Bvh& bvh) : scene_(scene), mesh_(mesh), bvh_(bvh) {}

    uint32_t leaf(const TreeNode& node, uint32_t firstTriangle) const {
        if (node.isInstance()) return REF_INSTANCE | node.primitives[0].primID;
        for (uint32_t i = 0; i < node.count; i++) triangle(node.primitives[i], firstTriangle + i);
        return REF_TRIANGLES | node.count << 27 | firstTriangle;
    }

    void inner(TreeNode* node, uint32_t index, uint32_t firstTriangle, uint32_t level) const {
        Children children(node, bvh_.width);
        uint32_t refs[4], triangles[4], next = index + 1;
        for (uint32_t i = 0; i < children.count; i++) {
            triangles[i] = firstTriangle;
            refs[i] = next;
            next += children.at[i].node->nodes;
            firstTriangle += children.at[i].node->triangles;
        }
        visitAll(children, level, [&](uint32_t i) {
            if (children.at[i].node->isLeaf()) refs[i] = leaf(*children.at[i].node, triangles[i]);
            else inner(children.at[i].node, refs[i], triangles[i], level + 1);
        });
        write(index, children.at, refs, children.count);
    }

    void write(uint32_t index, const Child* children, const uint32_t* refs, uint32_t count) const {
        uvec4* out = bvh_.nodes.data.get() + size_t(index) * WORDS16_PER_NODE;
        if (bvh_.width == 2) writeFloat(out, children, refs, count);
        else writeQuantised(out, children, refs, count);
    }

    Box leafBox(const TreeNode& node) const {
        Box box;
        for (uint32_t i = 0; i < node.count; i++) {
            const RTCBuildPrimitive& p = node.primitives[i];
            box.grow({{p.lower_x, p.lower_y, p.lower_z}, {p.upper_x, p.upper_y, p.upper_z}});
        }
        return box;
    }

private:
    static uint32_t bits(float x) { return std::bit_cast<uint32_t>(x); }

    /// A ray in the plane of a side, across whose axis it does not move, is in the box: the slab test (inverseDirection) would
    /// have it leave at once. Quantised boxes have such room by their rounding.
    static Box roomy(const Box& box) {
        const auto room = [](float x) { return std::abs(x) * 0x1p-22f + 1e-20f; };
        Box out;
        for (int axis = 0; axis < 3; axis++) {
            out.low[axis] = box.low[axis] - room(box.low[axis]);
            out.high[axis] = box.high[axis] + room(box.high[axis]);
        }
        return out;
    }

    static void writeFloat(uvec4* out, const Child* children, const uint32_t* refs, uint32_t count) {
        Box a = roomy(children[0].box);
        Box b = count > 1 ? roomy(children[1].box) : Box{vec3(0.0f), vec3(0.0f)};
        out[0] = {bits(a.low.x), bits(a.high.x), bits(a.low.y), bits(a.high.y)};
        out[1] = {bits(b.low.x), bits(b.high.x), bits(b.low.y), bits(b.high.y)};
        out[2] = {bits(a.low.z), bits(a.high.z), bits(b.low.z), bits(b.high.z)};
        out[3] = {refs[0], count > 1 ? refs[1] : REF_EMPTY, 0, 0};
    }

    static void writeQuantised(uvec4* out, const Child* children, const uint32_t* refs, uint32_t count) {
        Box whole;
        for (uint32_t i = 0; i < count; i++) whole.grow(children[i].box);
        uint32_t exponents[3], low[3] = {0, 0, 0}, high[3] = {0, 0, 0};
        for (int axis = 0; axis < 3; axis++) {
            Grid grid(whole.low[axis], whole.high[axis]);
            exponents[axis] = static_cast<uint32_t>(grid.exponent + 127);
            for (uint32_t i = 0; i < count; i++) {
                low[axis] |= grid.below(children[i].box.low[axis]) << (8 * i);
                high[axis] |= grid.above(children[i].box.high[axis]) << (8 * i);
            }
            whole.low[axis] = grid.origin;
        }
        out[0] = {bits(whole.low.x), bits(whole.low.y), bits(whole.low.z),
                  exponents[0] | exponents[1] << 8 | exponents[2] << 16};
        out[1] = {low[0], high[0], low[1], high[1]};
        out[2] = {low[2], high[2], 0, 0};
        for (uint32_t i = 0; i < 4; i++) out[3][static_cast<int>(i)] = i < count ? refs[i] : REF_EMPTY;
    }

    void triangle(const RTCBuildPrimitive& primitive, uint32_t index) const {
        uint32_t mesh = primitive.geomID == NO_INDEX ? mesh_ : scene_.instances[primitive.geomID].mesh;
        const Mesh& from = scene_.meshes[mesh];
        uvec4 corners = scene_.triangles[size_t(from.firstTriangle) + primitive.primID];
        const uint32_t beside[3] = {primitive.primID, primitive.geomID, from.opacity};
        uvec4* out = bvh_.triangles.data.get() + size_t(index) * WORDS16_PER_TRIANGLE;
        for (int i = 0; i < 3; i++) {
            vec4 p = scene_.positions[corners[i]];
            out[i] = {bits(p.x), bits(p.y), bits(p.z), beside[i]};
        }
    }

    const Scene& scene_;
    uint32_t mesh_;
    Bvh& bvh_;
};

}  // namespace

TreeLayout::TreeLayout(TreeNode* root, uint32_t width) : root_(root), width_(width) {
    if (!root_) return;
    countTree(root_, width_, 0);
    triangles_ = root_->triangles;
    if (root_->isLeaf()) return;
    nodes_ = root_->nodes;
    depth_ = root_->depth;
}

void TreeLayout::emit(const Scene& scene, uint32_t mesh, Bvh& bvh, uint32_t firstNode, uint32_t firstTriangle) const {
    Emitter emitter(scene, mesh, bvh);
    if (root_ && !root_->isLeaf()) {
        emitter.inner(root_, firstNode, firstTriangle, 0);
        return;
    }
    // A tree of one leaf or of nothing still begins with a node.
    Child only{root_, Box{vec3(0.0f), vec3(0.0f)}};
    uint32_t ref = REF_EMPTY;
    if (root_) {
        only.box = emitter.leafBox(*root_);
        ref = emitter.leaf(*root_, firstTriangle);
    }
    emitter.write(firstNode, &only, &ref, 1);
}

}  // namespace heliograph

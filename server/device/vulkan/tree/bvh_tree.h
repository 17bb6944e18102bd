#pragma once
// The binary tree between the builder and the layouts. Private to the vulkan folder.

#include "server/device/vulkan/tree/bvh_layout.h"

#include <embree3/rtcore.h>

#include <span>

namespace heliograph {

struct Box {
    vec3 low{1e30f};
    vec3 high{-1e30f};
    void grow(const Box& other) {
        low = glm::min(low, other.low);
        high = glm::max(high, other.high);
    }
    float halfArea() const {
        vec3 d = high - low;
        return d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

/// A leaf holds triangles only, or one instance. A triangle's geomID is the instance it belongs to (root tree) or NO_INDEX,
/// its primID the triangle in the mesh; an instance's geomID is INSTANCE_MARK, its primID the instance.
struct TreeNode {
    static constexpr uint32_t INSTANCE_MARK = 0xfffffffeu;

    // Inner node.
    TreeNode* child[2] = {nullptr, nullptr};
    Box bounds[2];
    // Leaf.
    const RTCBuildPrimitive* primitives = nullptr;
    uint32_t count = 0;
    // Filled by the layout: of the whole subtree.
    uint32_t nodes = 0;
    uint32_t triangles = 0;
    uint32_t depth = 0;

    bool isLeaf() const { return child[0] == nullptr; }
    bool isInstance() const { return count == 1 && primitives[0].geomID == INSTANCE_MARK; }
};

/// A tree with its memory.
class BinaryTree {
public:
    /// Takes `primitives` (it reorders them). maxLeaf <= MAX_LEAF. Throws std::runtime_error when Embree refuses.
    BinaryTree(RTCDevice device, std::span<RTCBuildPrimitive> primitives, uint32_t maxLeaf, uint32_t quality);
    ~BinaryTree();
    BinaryTree(BinaryTree&& other) noexcept : bvh_(other.bvh_), root_(other.root_) { other.bvh_ = nullptr; }
    BinaryTree(const BinaryTree&) = delete;

    /// Null for a tree of nothing.
    TreeNode* root() const { return root_; }

private:
    RTCBVH bvh_ = nullptr;
    TreeNode* root_ = nullptr;
};

/// Writes a tree in the layout of `width`: counts first, so that the arrays can be allocated in one piece, then emits.
class TreeLayout {
public:
    /// Nodes, triangles and depth (levels of nodes) of the tree in this layout; at least one node.
    TreeLayout(TreeNode* root, uint32_t width);
    uint32_t nodes() const { return nodes_; }
    uint32_t triangles() const { return triangles_; }
    uint32_t depth() const { return depth_; }
    /// Corners of triangle `primitive` of a mesh come from `scene`; in the root tree the mesh is that of the instance, else
    /// it is `mesh`.
    void emit(const class Scene& scene, uint32_t mesh, Bvh& bvh, uint32_t firstNode, uint32_t firstTriangle) const;

private:
    TreeNode* root_;
    uint32_t width_;
    uint32_t nodes_ = 1;
    uint32_t triangles_ = 0;
    uint32_t depth_ = 1;
};

}  // namespace heliograph

#include "server/device/vulkan/tree/bvh_tree.h"

#include <cstring>
#include <new>
#include <stdexcept>

namespace heliograph {

namespace {

Box boxOf(const RTCBuildPrimitive& p) { return {{p.lower_x, p.lower_y, p.lower_z}, {p.upper_x, p.upper_y, p.upper_z}}; }

struct Build {
    uint32_t maxLeaf;
};

void* createNode(RTCThreadLocalAllocator allocator, unsigned int, void*) {
    return new (rtcThreadLocalAlloc(allocator, sizeof(TreeNode), 16)) TreeNode();
}

void setChildren(void* node, void** children, unsigned int, void*) {
    for (int i = 0; i < 2; i++) static_cast<TreeNode*>(node)->child[i] = static_cast<TreeNode*>(children[i]);
}

// May be called before the children are set.
void setBounds(void* node, const RTCBounds** bounds, unsigned int, void*) {
    for (int i = 0; i < 2; i++) {
        const RTCBounds& b = *bounds[i];
        static_cast<TreeNode*>(node)->bounds[i] = {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
    }
}

bool fitsLeaf(std::span<const RTCBuildPrimitive> primitives, uint32_t maxLeaf) {
    if (primitives.size() == 1) return true;
    if (primitives.size() > maxLeaf) return false;
    for (const auto& p : primitives)
        if (p.geomID == TreeNode::INSTANCE_MARK) return false;
    return true;
}

// Embree's leaf as ours: halved until every piece is of one kind and small.
TreeNode* makeLeaf(RTCThreadLocalAllocator allocator, std::span<const RTCBuildPrimitive> primitives, uint32_t maxLeaf) {
    auto* node = static_cast<TreeNode*>(createNode(allocator, 2, nullptr));
    if (fitsLeaf(primitives, maxLeaf)) {
        node->primitives = primitives.data();
        node->count = static_cast<uint32_t>(primitives.size());
        return node;
    }
    std::span<const RTCBuildPrimitive> halves[2] = {primitives.first(primitives.size() / 2),
                                                    primitives.subspan(primitives.size() / 2)};
    for (int i = 0; i < 2; i++) {
        node->child[i] = makeLeaf(allocator, halves[i], maxLeaf);
        for (const auto& p : halves[i]) node->bounds[i].grow(boxOf(p));
    }
    return node;
}

void* createLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t count, void* user) {
    // The builder's array does not outlive the build.
    void* memory = rtcThreadLocalAlloc(allocator, count * sizeof(RTCBuildPrimitive), 32);
    std::memcpy(memory, primitives, count * sizeof(RTCBuildPrimitive));
    return makeLeaf(allocator, {static_cast<RTCBuildPrimitive*>(memory), count}, static_cast<Build*>(user)->maxLeaf);
}

}  // namespace

BinaryTree::BinaryTree(RTCDevice device, std::span<RTCBuildPrimitive> primitives, uint32_t maxLeaf, uint32_t quality) {
    if (primitives.empty()) return;
    bvh_ = rtcNewBVH(device);
    Build build{maxLeaf};
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = quality == 0 ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = 2;
    arguments.maxDepth = 56;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = maxLeaf;
    arguments.bvh = bvh_;
    arguments.primitives = primitives.data();
    arguments.primitiveCount = primitives.size();
    arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = createNode;
    arguments.setNodeChildren = setChildren;
    arguments.setNodeBounds = setBounds;
    arguments.createLeaf = createLeaf;
    arguments.userPtr = &build;
    root_ = static_cast<TreeNode*>(rtcBuildBVH(&arguments));
    if (!root_) {
        RTCError error = rtcGetDeviceError(device);
        rtcReleaseBVH(bvh_);
        throw std::runtime_error("Embree could not build a tree (error " + std::to_string(error) + ")");
    }
}

BinaryTree::~BinaryTree() {
    if (bvh_) rtcReleaseBVH(bvh_);
}

}  // namespace heliograph

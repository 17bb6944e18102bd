#pragma once
// Trees as shaders/vulkan/bvh.glsl reads them.

#include "server/kernel/kernel_types.h"

#include <memory>
#include <vector>

namespace heliograph {

// References to children: an inner node's index; a leaf of up to MAX_LEAF triangles; one instance.
constexpr uint32_t REF_TRIANGLES = 0x80000000u;  // | count << 27 | first triangle
constexpr uint32_t REF_INSTANCE = 0xc0000000u;   // | instance
constexpr uint32_t REF_EMPTY = REF_TRIANGLES;    // a leaf of no triangles
constexpr uint32_t MAX_LEAF = 7;
constexpr uint64_t MAX_TRIANGLES = 1u << 27;
constexpr uint64_t MAX_WIDE_NODES = (1u << 24) - 1;  // of trees of four: what waits names its node in 24 bits

constexpr uint32_t WORDS16_PER_NODE = 4;      // 64 bytes
constexpr uint32_t WORDS16_PER_TRIANGLE = 3;  // corners; beside them: primitive, instance or NO_INDEX, OPACITY_*

/// An array that is not cleared before it is filled.
struct Words16 {
    std::unique_ptr<uvec4[]> data;
    size_t count = 0;
    explicit Words16(size_t n = 0) : data(std::make_unique_for_overwrite<uvec4[]>(n)), count(n) {}
    uint64_t bytes() const { return count * sizeof(uvec4); }
};

struct Bvh {
    uint32_t width = 2;  // children of a node: 2 or 4
    Words16 nodes;       // the root is node 0
    Words16 triangles;
    std::vector<uint32_t> meshRoots;  // root node by mesh, NO_INDEX for those that are not placed
    uint32_t stackDepth = 0;          // entries that the traversal can need
};

}  // namespace heliograph

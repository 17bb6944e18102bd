#pragma once
// Triangles that Draco compressed, as plain arrays. The door to libdraco; knows no glTF. Private to server/scene.

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

/// Triangles that may still be decoded, shared by all meshes of a file: what a mesh claims to hold is taken from it before any
/// memory is.
using DracoBudget = std::atomic<int64_t>;

/// An attribute that is wanted, by the id that the compressed mesh knows it by, and how its components are to be stored.
struct DracoAttribute {
    uint32_t id = 0;
    int componentType = 0;  // glTF's: 5120 to 5126
    int components = 0;     // of one element, 1 to 4
};

struct DracoMesh {
    size_t points = 0;
    std::vector<uint32_t> indices;                 // three a triangle, below `points`
    std::vector<std::vector<uint8_t>> attributes;  // one per wanted attribute: `points` elements without gaps
};

/// Decodes a mesh of bitstream 2.2 or before, edgebreaker or sequential. Throws std::runtime_error with what is wrong: data that
/// ends early, claims that the data cannot hold, a wanted attribute that is not there. Safe from any thread.
DracoMesh decodeDraco(std::span<const uint8_t> bytes, std::span<const DracoAttribute> wanted, DracoBudget& budget);

}  // namespace heliograph

// What the Vulkan tracer and the C++ that feeds it agree on, in one file for both: the bindings of the one descriptor set,
// the tiles and the counts (server/device/vulkan/trace/bindings.h asserts the layouts).
#ifndef HELIOGRAPH_BINDINGS_GLSL
#define HELIOGRAPH_BINDINGS_GLSL

// The kernel's, then the tree's.
UINT_CONSTANT(BINDING_FRAME, 0u)
UINT_CONSTANT(BINDING_POSITIONS, 1u)
UINT_CONSTANT(BINDING_ATTRIBUTES, 2u)
UINT_CONSTANT(BINDING_TANGENTS, 3u)
UINT_CONSTANT(BINDING_TRIANGLES, 4u)
UINT_CONSTANT(BINDING_MESHES, 5u)
UINT_CONSTANT(BINDING_INSTANCES, 6u)
UINT_CONSTANT(BINDING_MATERIALS, 7u)
UINT_CONSTANT(BINDING_TEXTURES, 8u)
UINT_CONSTANT(BINDING_IMAGES, 9u)
UINT_CONSTANT(BINDING_IMAGE_LEVELS, 10u)
UINT_CONSTANT(BINDING_TEXELS, 11u)
UINT_CONSTANT(BINDING_LIGHTS, 12u)
UINT_CONSTANT(BINDING_SOBOL, 13u)
UINT_CONSTANT(BINDING_BVH_NODES, 14u)
UINT_CONSTANT(BINDING_BVH_TRIANGLES, 15u)
// trace.comp's own.
UINT_CONSTANT(BINDING_TILES, 16u)
UINT_CONSTANT(BINDING_SUMS, 17u)
UINT_CONSTANT(BINDING_COUNTS, 18u)
UINT_CONSTANT(BINDING_COUNT, 19u)
// rays.comp's own, in the places of tiles and sums.
UINT_CONSTANT(BINDING_RAYS, 16u)
UINT_CONSTANT(BINDING_HITS, 17u)

// A tile as trace.comp knows it. 32 bytes.
struct TraceTile {
    uvec2 origin;      // pixels
    uvec2 size;
    uint firstSample;
    uint sampleCount;
    uint firstGroup;   // workgroups of 8 x 8 pixels, row by row
    uint firstPixel;   // in the sums
};

// Counts of a tile: rays by kind, samples that are not finite, paths that the program for the first surface alone ended, rays that
// no instance could be tested with, paths that left a body without having entered it, paths in more bodies than they can tell.
#define RAY_KIND(number, NAME, name, word) UINT_CONSTANT(COUNT_##NAME, number)
#include "shaders/kernel/ray_table.glsl"
UINT_CONSTANT(COUNT_NONFINITE, 5u)
UINT_CONSTANT(COUNT_CUT_OFF, 6u)
UINT_CONSTANT(COUNT_UNTRACEABLE, 7u)
UINT_CONSTANT(COUNT_MEDIA_UNDERFLOW, 8u)
UINT_CONSTANT(COUNT_MEDIA_OVERFLOW, 9u)
UINT_CONSTANT(COUNTS_PER_TILE, 10u)

#endif

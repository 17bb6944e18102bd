#pragma once
// The compiled shaders, embedded in the program (cmake/embed_spirv.cmake); unpacked when they are first asked for.

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph::shaders {

using Words = std::span<const uint32_t>;

/// What gzip packed: the first bytes of all words, then their second ones and so on. Throws std::runtime_error unless that is exactly `bytes`, whole words.
std::vector<uint32_t> unpacked(std::span<const unsigned char> packed, size_t bytes);

Words traceWide2();  // trace.comp for trees of two children, storage buffers
Words traceWide4();  // for quantised trees of four, texel buffers
Words raysWide2();   // rays.comp, likewise
Words raysWide4();
Words denoise();
Words rasterVertex();  // the preview
Words rasterFragment();
Words anchorGenerate();  // the driver's ray tracing pipeline
Words anchorHit();
Words anchorMiss();

}  // namespace heliograph::shaders

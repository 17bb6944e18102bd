#pragma once
// The compiled shaders, embedded in the program (cmake/embed_spirv.cmake).

#include <cstdint>
#include <span>

namespace heliograph::shaders {

extern const std::span<const uint32_t> traceWide2;  // trace.comp for trees of two children, storage buffers
extern const std::span<const uint32_t> traceWide4;  // for quantised trees of four, texel buffers
extern const std::span<const uint32_t> raysWide2;   // rays.comp, likewise
extern const std::span<const uint32_t> raysWide4;
extern const std::span<const uint32_t> rasterVertex;  // the preview
extern const std::span<const uint32_t> rasterFragment;
extern const std::span<const uint32_t> anchorGenerate;  // the driver's ray tracing pipeline
extern const std::span<const uint32_t> anchorHit;
extern const std::span<const uint32_t> anchorMiss;

}  // namespace heliograph::shaders

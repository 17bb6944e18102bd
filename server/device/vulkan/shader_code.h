#pragma once
// The compiled shaders, embedded in the program (cmake/embed_spirv.cmake).

#include <cstdint>
#include <span>

namespace heliograph::shaders {

extern const std::span<const uint32_t> traceWide2;    // trace.comp for trees of two children, storage buffers
extern const std::span<const uint32_t> traceWide4;    // for quantised trees of four, texel buffers

}  // namespace heliograph::shaders

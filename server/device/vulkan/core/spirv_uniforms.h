#pragma once
// Keeps a driver from compiling a shader again for the values of its uniforms.

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

/// The compute module with 32-bit numbers of its uniform blocks read so that a driver cannot tell that all invocations see the
/// same: the value or a zero that depends on the invocation. Lavapipe (Mesa 22.3) puts what conditions read from uniforms into a
/// copy of the shader, for every dispatch, and keeps each copy as long as the pipeline. Unchanged without uniform blocks or
/// without gl_LocalInvocationID. Throws std::invalid_argument if it is not a SPIR-V module.
std::vector<uint32_t> withOpaqueUniforms(std::span<const uint32_t> module);

}  // namespace heliograph

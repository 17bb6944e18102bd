#pragma once
// The filter's part of the kernel as scalar C++ (server/kernel/kernel.h has the rest).

#include "server/kernel/kernel_types.h"

#define IN(T) const T&
#define OUT(T) T&
#define INOUT(T) T&
#define SELECT(condition, yes, no) ((condition) ? (yes) : (no))
#define ANY(condition) (condition)
#define FLOAT_CONSTANT(name, value) static constexpr float name = value;
#define UINT_CONSTANT(name, value) static constexpr uint32_t name = value;
#define UNIFORM_UINT uint32_t

namespace heliograph::scalar_kernel {

using glm::abs;
using glm::dot;
using glm::floatBitsToInt;
using glm::floor;
using glm::intBitsToFloat;
using glm::max;
using glm::min;
using glm::sqrt;

struct DenoiseKernel {
#include "shaders/kernel/math.glsl"
#include "shaders/denoise/filter.glsl"
};

}  // namespace heliograph::scalar_kernel

#include "server/kernel/kernel_undefine.inc"

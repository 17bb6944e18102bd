#pragma once
// Shaders that compute what they say: no fused or reordered arithmetic, quotients and square roots to the last bit.

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

/// The module with NoContraction on every floating-point sum, difference, product, quotient and negation. Throws
/// std::invalid_argument if it is not a SPIR-V module.
std::vector<uint32_t> withoutContraction(std::span<const uint32_t> module);

/// The module with every quotient and square root of 32-bit floats rounded to nearest, as IEEE 754 has them, where Vulkan
/// allows a driver an error of 2.5 ulp and more (specification, "Precision and Operation of SPIR-V Instructions"). The
/// driver's value is mended by fused multiply-adds: Markstein, "Computation of Elementary Functions on the IBM RISC
/// System/6000 Processor", 1990. Left to the driver: operands and results so large or small that a step overflows or
/// vanishes. Throws std::invalid_argument if it is not a SPIR-V module, or divides vectors.
std::vector<uint32_t> withExactQuotients(std::span<const uint32_t> module);

}  // namespace heliograph

#pragma once
// Shaders that compute what they say: no fused or reordered arithmetic.

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

/// The module with NoContraction on every floating-point sum, difference, product, quotient and negation. Throws
/// std::invalid_argument if it is not a SPIR-V module.
std::vector<uint32_t> withoutContraction(std::span<const uint32_t> module);

}  // namespace heliograph

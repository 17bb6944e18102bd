#pragma once
// Shaders without what a set of specialisation constants never reaches, before a driver sees them.

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

/// The module with its specialisation constants fixed: constant_id n has the word `constants[n]` (booleans: 0 or not), those
/// from constants.size() on their defaults. Blocks that no path leads to and functions that nothing calls are left out, so a
/// driver that specialises late, as lavapipe does, needn't translate them first. Arithmetic stays as it is. Source: Wegman and
/// Zadeck, "Constant Propagation with Conditional Branches", 1991, for booleans and 32-bit integers. Throws
/// std::invalid_argument if it is not a SPIR-V module, or its blocks are not in order.
std::vector<uint32_t> specialised(std::span<const uint32_t> module, std::span<const uint32_t> constants);

}  // namespace heliograph

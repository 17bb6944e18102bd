#pragma once
// Mutations of an input, as fuzzers make them: bits, lengths, numbers at the ends of their ranges, pieces of other inputs.
// A seed gives the same inputs everywhere.

#include "tests/support/random.h"

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph::fuzz {

using Bytes = std::vector<uint8_t>;

/// `from` with 1 to 8 changes, at most `mostBytes` long. `others` (not empty) are what pieces are taken from.
Bytes mutated(const Bytes& from, std::span<const Bytes> others, test::Random& random, size_t mostBytes);

}  // namespace heliograph::fuzz

#pragma once
// Sanitizers run code ten times slower: what tests repeat at random is repeated less there.

#include <algorithm>
#include <cstdint>

namespace heliograph::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool SANITIZED = true;
#else
constexpr bool SANITIZED = false;
#endif

/// How often to repeat what is repeated `rounds` times without sanitizers.
constexpr uint32_t repeated(uint32_t rounds) { return SANITIZED ? std::max(1u, rounds / 10) : rounds; }

}  // namespace heliograph::test

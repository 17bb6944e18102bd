#pragma once
// SHA-256, by which scenes, their parts and builds of the program are named. Calls OpenSSL.

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace heliograph {

using Digest = std::array<uint8_t, 32>;

/// Throws std::runtime_error where the library refuses.
Digest digestOf(std::span<const uint8_t> bytes);
/// Of the program that runs: pictures of another build may differ. Throws std::runtime_error where it cannot be read.
Digest buildDigest();
/// Lower-case hexadecimal; of the first `bytes` bytes.
std::string hexOf(const Digest& digest, size_t bytes = 32);

}  // namespace heliograph

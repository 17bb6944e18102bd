#pragma once
// The words of a SPIR-V module (specification, section 2.3).

#include <cstdint>
#include <span>
#include <stdexcept>

namespace heliograph::spirv {

inline constexpr uint32_t MAGIC = 0x07230203;
inline constexpr uint32_t HEADER_WORDS = 5;
inline constexpr uint32_t ID_BOUND = 3;  // which word of the header is greater than all ids

/// Calls `visit(op, instruction)` for each instruction. Throws std::invalid_argument if it is not a SPIR-V module.
template <typename Visit>
void forEachInstruction(std::span<const uint32_t> module, Visit visit) {
    if (module.size() < HEADER_WORDS || module[0] != MAGIC) throw std::invalid_argument("not a SPIR-V module");
    for (size_t at = HEADER_WORDS; at < module.size();) {
        const uint32_t words = module[at] >> 16;
        if (words == 0 || at + words > module.size()) throw std::invalid_argument("a SPIR-V module with a broken instruction");
        visit(module[at] & 0xffffu, module.subspan(at, words));
        at += words;
    }
}

}  // namespace heliograph::spirv

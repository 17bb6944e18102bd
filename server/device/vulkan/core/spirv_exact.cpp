#include "server/device/vulkan/core/spirv_exact.h"

#include <stdexcept>

namespace heliograph {

namespace {

// Numbers of the SPIR-V specification, section 3.
constexpr uint32_t MAGIC = 0x07230203;
constexpr uint32_t HEADER_WORDS = 5;
constexpr uint32_t OP_DECORATE = 71;
constexpr uint32_t OP_TYPE_FIRST = 19;  // OpTypeVoid; annotations come before all types
constexpr uint32_t NO_CONTRACTION = 42;

bool isFloatArithmetic(uint32_t op) {
    switch (op) {
        case 127:  // OpFNegate
        case 129:  // OpFAdd
        case 131:  // OpFSub
        case 133:  // OpFMul
        case 136:  // OpFDiv
        case 142:  // OpVectorTimesScalar
            return true;
        default: return false;
    }
}

}  // namespace

std::vector<uint32_t> withoutContraction(std::span<const uint32_t> module) {
    if (module.size() < HEADER_WORDS || module[0] != MAGIC) throw std::invalid_argument("not a SPIR-V module");
    std::vector<uint32_t> decorations;
    size_t annotationsEnd = 0;
    for (size_t at = HEADER_WORDS; at < module.size();) {
        uint32_t op = module[at] & 0xffffu;
        uint32_t words = module[at] >> 16;
        if (words == 0 || at + words > module.size()) throw std::invalid_argument("a SPIR-V module with a broken instruction");
        if (annotationsEnd == 0 && op >= OP_TYPE_FIRST && op < 39) annotationsEnd = at;
        if (isFloatArithmetic(op))
            decorations.insert(decorations.end(), {3u << 16 | OP_DECORATE, module[at + 2], NO_CONTRACTION});
        at += words;
    }
    if (annotationsEnd == 0) throw std::invalid_argument("a SPIR-V module without types");
    std::vector<uint32_t> result(module.begin(), module.begin() + static_cast<long>(annotationsEnd));
    result.insert(result.end(), decorations.begin(), decorations.end());
    result.insert(result.end(), module.begin() + static_cast<long>(annotationsEnd), module.end());
    return result;
}

}  // namespace heliograph

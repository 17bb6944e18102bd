#include "server/device/vulkan/core/spirv_exact.h"

#include "server/device/vulkan/core/spirv_module.h"

#include <bit>
#include <stdexcept>
#include <utility>

namespace heliograph {

using namespace spirv;

namespace {

// Numbers of the SPIR-V specification, section 3.
constexpr uint32_t OP_DECORATE = 71;
constexpr uint32_t OP_TYPE_FIRST = 19;  // OpTypeVoid; annotations come before all types
constexpr uint32_t OP_IMPORT = 11;
constexpr uint32_t OP_EXTENDED = 12;
constexpr uint32_t OP_TYPE_BOOL = 20;
constexpr uint32_t OP_TYPE_FLOAT = 22;
constexpr uint32_t OP_CONSTANT = 43;
constexpr uint32_t OP_FUNCTION = 54;
constexpr uint32_t OP_NEGATE = 127;
constexpr uint32_t OP_MULTIPLY = 133;
constexpr uint32_t OP_DIVIDE = 136;
constexpr uint32_t OP_AND = 167;
constexpr uint32_t OP_SELECT = 169;
constexpr uint32_t OP_EQUAL = 180;  // false for what is not a number
constexpr uint32_t OP_LESS = 184;
constexpr uint32_t NO_CONTRACTION = 42;
// Of GLSL.std.450.
constexpr uint32_t ABSOLUTE = 4;
constexpr uint32_t ROOT = 31;
constexpr uint32_t INVERSE_ROOT = 32;
constexpr uint32_t FUSED = 50;

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

/// Writes a module again with other code for its quotients and roots.
class QuotientWriter {
public:
    explicit QuotientWriter(std::span<const uint32_t> module) : module_(module) {}

    std::vector<uint32_t> written() {
        forEachInstruction(module_, [&](uint32_t op, std::span<const uint32_t> words) { learn(op, words); });
        if (float_ == 0 || extended_ == 0) return {module_.begin(), module_.end()};  // nothing to divide
        result_.assign(module_.begin(), module_.begin() + HEADER_WORDS);
        nextId_ = module_[3];
        bool inCode = false;
        forEachInstruction(module_, [&](uint32_t op, std::span<const uint32_t> words) {
            if (op == OP_FUNCTION && !std::exchange(inCode, true)) declare();
            if (op == OP_DIVIDE && words[1] == float_) quotient(words[2], words[3], words[4]);
            else if (op == OP_DIVIDE) throw std::invalid_argument("a SPIR-V module that divides vectors");
            else if (op == OP_EXTENDED && words[1] == float_ && words[3] == extended_ && words[4] == ROOT)
                root(words[2], words[5]);
            else result_.insert(result_.end(), words.begin(), words.end());
        });
        result_[3] = nextId_;
        return std::move(result_);
    }

private:
    void learn(uint32_t op, std::span<const uint32_t> words) {
        if (op == OP_IMPORT && words.size() > 5 && words[2] == 0x4c534c47) extended_ = words[1];  // "GLSL.std.450"
        if (op == OP_TYPE_FLOAT && words[2] == 32) float_ = words[1];
        if (op == OP_TYPE_BOOL) bool_ = words[1];
    }

    void put(uint32_t op, std::initializer_list<uint32_t> operands) {
        result_.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | op);
        result_.insert(result_.end(), operands);
    }
    uint32_t made(uint32_t op, uint32_t type, std::initializer_list<uint32_t> operands) {
        const uint32_t id = nextId_++;
        result_.push_back(static_cast<uint32_t>(operands.size() + 3) << 16 | op);
        result_.insert(result_.end(), {type, id});
        result_.insert(result_.end(), operands);
        return id;
    }
    uint32_t constant(float value) { return made(OP_CONSTANT, float_, {std::bit_cast<uint32_t>(value)}); }
    uint32_t negated(uint32_t a) { return made(OP_NEGATE, float_, {a}); }
    uint32_t product(uint32_t a, uint32_t b) { return made(OP_MULTIPLY, float_, {a, b}); }
    uint32_t fused(uint32_t a, uint32_t b, uint32_t c) { return made(OP_EXTENDED, float_, {extended_, FUSED, a, b, c}); }

    void declare() {
        if (bool_ == 0) put(OP_TYPE_BOOL, {bool_ = nextId_++});
        one_ = constant(1.0f);
        half_ = constant(0.5f);
        large_ = constant(0x1p126f);  // the reciprocal of what is larger vanishes
    }

    /// `result` = `exact`, or `given` where a step overflowed or `operand` is too large.
    void choose(uint32_t result, uint32_t exact, uint32_t given, uint32_t operand) {
        const uint32_t size = made(OP_EXTENDED, float_, {extended_, ABSOLUTE, operand});
        const uint32_t small = made(OP_LESS, bool_, {size, large_});
        const uint32_t number = made(OP_EQUAL, bool_, {exact, exact});
        put(OP_SELECT, {float_, result, made(OP_AND, bool_, {small, number}), exact, given});
    }

    /// The reciprocal to the last bit, then a step towards the quotient by the exact remainder.
    void quotient(uint32_t result, uint32_t a, uint32_t b) {
        const uint32_t given = made(OP_DIVIDE, float_, {a, b}), minus = negated(b);
        const uint32_t rough = made(OP_DIVIDE, float_, {one_, b});
        const uint32_t reciprocal = fused(fused(minus, rough, one_), rough, rough);
        const uint32_t near = product(a, reciprocal);
        choose(result, fused(fused(minus, near, a), reciprocal, near), given, b);
    }

    /// Root and half the inverse root together, then a step by the exact remainder.
    void root(uint32_t result, uint32_t x) {
        const uint32_t given = made(OP_EXTENDED, float_, {extended_, ROOT, x});
        const uint32_t inverse = made(OP_EXTENDED, float_, {extended_, INVERSE_ROOT, x});
        const uint32_t rough = product(x, inverse), half = product(half_, inverse);
        const uint32_t error = fused(negated(half), rough, half_);
        const uint32_t near = fused(rough, error, rough), halfInverse = fused(half, error, half);
        const uint32_t exact = fused(fused(negated(near), near, x), halfInverse, near);
        choose(result, exact, given, x);
    }

    const std::span<const uint32_t> module_;
    std::vector<uint32_t> result_;
    uint32_t nextId_ = 0;
    uint32_t extended_ = 0, float_ = 0, bool_ = 0;  // ids of the module
    uint32_t one_ = 0, half_ = 0, large_ = 0;
};

}  // namespace

std::vector<uint32_t> withExactQuotients(std::span<const uint32_t> module) { return QuotientWriter(module).written(); }

std::vector<uint32_t> withoutContraction(std::span<const uint32_t> module) {
    std::vector<uint32_t> decorations;
    size_t annotationsEnd = 0, at = HEADER_WORDS;
    forEachInstruction(module, [&](uint32_t op, std::span<const uint32_t> words) {
        if (annotationsEnd == 0 && op >= OP_TYPE_FIRST && op < 39) annotationsEnd = at;
        if (isFloatArithmetic(op)) decorations.insert(decorations.end(), {3u << 16 | OP_DECORATE, words[2], NO_CONTRACTION});
        at += words.size();
    });
    if (annotationsEnd == 0) throw std::invalid_argument("a SPIR-V module without types");
    std::vector<uint32_t> result(module.begin(), module.begin() + static_cast<long>(annotationsEnd));
    result.insert(result.end(), decorations.begin(), decorations.end());
    result.insert(result.end(), module.begin() + static_cast<long>(annotationsEnd), module.end());
    return result;
}

}  // namespace heliograph

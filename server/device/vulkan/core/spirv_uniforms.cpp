#include "server/device/vulkan/core/spirv_uniforms.h"

#include "server/device/vulkan/core/spirv_module.h"

#include <initializer_list>
#include <map>
#include <set>
#include <utility>

namespace heliograph {

using namespace spirv;

namespace {

class OpaqueWriter {
public:
    explicit OpaqueWriter(std::span<const uint32_t> module) : module_(module) {}

    std::vector<uint32_t> written() {
        forEachInstruction(module_, [&](uint32_t op, std::span<const uint32_t> words) { learn(op, words); });
        if (number_ == 0 || invocation_ == 0 || numbers_.empty()) return {module_.begin(), module_.end()};
        result_.assign(module_.begin(), module_.begin() + HEADER_WORDS);
        nextId_ = module_[ID_BOUND];
        allBits_ = nextId_++;
        bool inCode = false;
        forEachInstruction(module_, [&](uint32_t op, std::span<const uint32_t> words) {
            if (op == FUNCTION && !std::exchange(inCode, true)) put(CONSTANT, {number_, allBits_, ALL_BITS});
            if (op == LOAD && numbers_.contains(words[3])) load(words);
            else result_.insert(result_.end(), words.begin(), words.end());
        });
        result_[ID_BOUND] = nextId_;
        return std::move(result_);
    }

private:
    // Numbers of the SPIR-V specification, section 3.
    enum Op : uint32_t {
        TYPE_INT = 21,
        TYPE_FLOAT = 22,
        TYPE_POINTER = 32,
        CONSTANT = 43,
        FUNCTION = 54,
        VARIABLE = 59,
        LOAD = 61,
        ACCESS_CHAIN = 65,
        DECORATE = 71,
        COMPOSITE_EXTRACT = 81,
        BITCAST = 124,
        SHIFT_RIGHT = 194,
        BITWISE_OR = 197
    };
    static constexpr uint32_t UNIFORM = 2, BUILT_IN = 11, LOCAL_INVOCATION_ID = 27;  // storage class, decoration, built-in
    static constexpr uint32_t ALL_BITS = 31;  // an invocation's number shifted right by so many is 0

    void learn(uint32_t op, std::span<const uint32_t> words) {
        switch (op) {
            case TYPE_INT:
                if (words[2] == 32 && words[3] == 0) number_ = words[1];
                break;
            case TYPE_FLOAT:
                if (words[2] == 32) float_ = words[1];
                break;
            case TYPE_POINTER:
                pointees_[words[1]] = words[3];
                if (words[2] == UNIFORM && (words[3] == number_ || words[3] == float_)) uniform_.insert(words[1]);
                break;
            case DECORATE:
                if (words.size() > 3 && words[2] == BUILT_IN && words[3] == LOCAL_INVOCATION_ID) invocation_ = words[1];
                break;
            case VARIABLE:
                if (words[2] == invocation_) numbersOfThree_ = pointees_[words[1]];
                break;
            case ACCESS_CHAIN:
                if (uniform_.contains(words[1])) numbers_.insert(words[2]);
                break;
            default: break;
        }
    }

    /// Reads a number and joins the bits of a zero.
    void load(std::span<const uint32_t> words) {
        const uint32_t type = words[1], result = words[2];
        const uint32_t invocation = next(), first = next(), zero = next(), value = next();
        put(LOAD, {numbersOfThree_, invocation, invocation_});
        put(COMPOSITE_EXTRACT, {number_, first, invocation, 0});
        put(SHIFT_RIGHT, {number_, zero, first, allBits_});
        result_.insert(result_.end(), words.begin(), words.end());
        result_[result_.size() - words.size() + 2] = value;
        if (type == number_) return put(BITWISE_OR, {type, result, value, zero});
        const uint32_t bits = next(), joined = next();
        put(BITCAST, {number_, bits, value});
        put(BITWISE_OR, {number_, joined, bits, zero});
        put(BITCAST, {type, result, joined});
    }

    void put(uint32_t op, std::initializer_list<uint32_t> operands) {
        result_.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | op);
        result_.insert(result_.end(), operands);
    }
    uint32_t next() { return nextId_++; }

    const std::span<const uint32_t> module_;
    std::vector<uint32_t> result_;
    uint32_t nextId_ = 0;
    uint32_t number_ = 0, float_ = 0, numbersOfThree_ = 0;  // types
    uint32_t invocation_ = 0, allBits_ = 0;                 // gl_LocalInvocationID, a constant
    std::map<uint32_t, uint32_t> pointees_;                 // types by pointers' types
    std::set<uint32_t> uniform_;                            // types of pointers to numbers of uniform blocks
    std::set<uint32_t> numbers_;                            // such pointers
};

}  // namespace

std::vector<uint32_t> withOpaqueUniforms(std::span<const uint32_t> module) { return OpaqueWriter(module).written(); }

}  // namespace heliograph

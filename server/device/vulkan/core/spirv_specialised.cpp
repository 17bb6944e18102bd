#include "server/device/vulkan/core/spirv_specialised.h"

#include "server/device/vulkan/core/spirv_module.h"

#include <algorithm>
#include <optional>

namespace heliograph {

using namespace spirv;

namespace {

// Numbers of the SPIR-V specification, section 3.
enum Op : uint32_t {
    NAME = 5,
    LINE = 8,
    ENTRY_POINT = 15,
    TYPE_BOOL = 20,
    TYPE_INT = 21,
    CONSTANT_TRUE = 41,
    CONSTANT_FALSE = 42,
    CONSTANT = 43,
    SPEC_CONSTANT_TRUE = 48,
    SPEC_CONSTANT_FALSE = 49,
    SPEC_CONSTANT = 50,
    SPEC_CONSTANT_OP = 52,
    FUNCTION = 54,
    FUNCTION_PARAMETER = 55,
    FUNCTION_END = 56,
    FUNCTION_CALL = 57,
    DECORATE = 71,
    COPY_OBJECT = 83,
    I_ADD = 128,
    I_SUB = 130,
    I_MUL = 132,
    LOGICAL_EQUAL = 164,
    LOGICAL_NOT_EQUAL = 165,
    LOGICAL_OR = 166,
    LOGICAL_AND = 167,
    LOGICAL_NOT = 168,
    SELECT = 169,
    I_EQUAL = 170,
    I_NOT_EQUAL = 171,
    U_GREATER = 172,
    U_GREATER_EQUAL = 174,
    U_LESS = 176,
    U_LESS_EQUAL = 178,
    SHIFT_RIGHT = 194,
    SHIFT_LEFT = 196,
    BITWISE_OR = 197,
    BITWISE_XOR = 198,
    BITWISE_AND = 199,
    NOT = 200,
    PHI = 245,
    LOOP_MERGE = 246,
    SELECTION_MERGE = 247,
    LABEL = 248,
    BRANCH = 249,
    BRANCH_CONDITIONAL = 250,
    SWITCH = 251,
    UNREACHABLE = 255,
    NO_LINE = 317,
};
constexpr uint32_t SPEC_ID = 1;  // a decoration

/// Instructions of functions that have no result.
bool withoutResult(uint32_t op) {
    switch (op) {
        case 0:  // OpNop
        case LINE:
        case FUNCTION_END:
        case 62:   // OpStore
        case 63:   // OpCopyMemory
        case 64:   // OpCopyMemorySized
        case 99:   // OpImageWrite
        case 224:  // OpControlBarrier
        case 225:  // OpMemoryBarrier
        case 228:  // OpAtomicStore
        case NO_LINE: return true;
        default: return op >= LOOP_MERGE && op <= 257 && op != LABEL;  // merges and ends of blocks
    }
}

struct Instruction {
    uint32_t op;
    std::span<const uint32_t> words;
};

/// What is known of a result. It only ever falls: not seen yet, one value, any value.
struct Known {
    enum State : uint8_t { NOT_YET, ONE, ANY } state = NOT_YET;
    uint32_t value = 0;

    static Known one(uint32_t value) { return {ONE, value}; }
    static Known any() { return {ANY, 0}; }
    bool is(uint32_t v) const { return state == ONE && value == v; }
    bool operator==(const Known&) const = default;
};

struct Block {
    uint32_t label;
    size_t first, end;  // its instructions, the label left out
    bool live = false;
    std::vector<uint32_t> next;  // labels that it may go on to
    uint32_t backTo = 0;         // it is not live, but the end of the loop of this label
    bool keepsLabel = false;     // it is not live, but another's merge block
};

struct Function {
    size_t first, end;
    std::vector<Block> blocks;
    bool live = false;
};

/// The value of an operation on booleans (0 and 1) and 32-bit integers whose operands all have one.
std::optional<uint32_t> computed(uint32_t op, uint32_t a, uint32_t b) {
    switch (op) {
        case COPY_OBJECT: return a;
        case I_ADD: return a + b;
        case I_SUB: return a - b;
        case I_MUL: return a * b;
        case LOGICAL_EQUAL:
        case I_EQUAL: return a == b;
        case LOGICAL_NOT_EQUAL:
        case I_NOT_EQUAL: return a != b;
        case LOGICAL_OR:
        case BITWISE_OR: return a | b;
        case LOGICAL_AND:
        case BITWISE_AND: return a & b;
        case LOGICAL_NOT: return a ^ 1u;
        case U_GREATER: return a > b;
        case U_GREATER_EQUAL: return a >= b;
        case U_LESS: return a < b;
        case U_LESS_EQUAL: return a <= b;
        case SHIFT_RIGHT: return b < 32 ? std::optional(a >> b) : std::nullopt;
        case SHIFT_LEFT: return b < 32 ? std::optional(a << b) : std::nullopt;
        case BITWISE_XOR: return a ^ b;
        case NOT: return ~a;
        default: return std::nullopt;
    }
}

class Specialiser {
public:
    Specialiser(std::span<const uint32_t> module, std::span<const uint32_t> constants)
        : module_(module), constants_(constants) {}

    std::vector<uint32_t> written() {
        split();
        for (size_t i = 0; i < globalsEnd_; i++) learnGlobal(instructions_[i]);
        forgetUnknown();
        while (!waiting_.empty()) {
            Function& function = functions_[waiting_.back()];
            waiting_.pop_back();
            follow(function);
        }
        for (const Function& f : functions_) forgetDead(f);
        result_.assign(module_.begin(), module_.begin() + HEADER_WORDS);
        for (size_t i = 0; i < globalsEnd_; i++) writeGlobal(instructions_[i]);
        for (const Function& f : functions_) {
            if (f.live) write(f);
        }
        return std::move(result_);
    }

private:
    void split() {
        forEachInstruction(module_, [&](uint32_t op, std::span<const uint32_t> words) {
            instructions_.push_back({op, words});
        });
        const uint32_t ids = module_[ID_BOUND];
        known_.resize(ids);
        gone_.resize(ids);
        specIds_.resize(ids, NONE);
        functionOf_.resize(ids, NONE);
        blockOf_.resize(ids, NONE);
        globalsEnd_ = instructions_.size();
        for (size_t i = 0; i < instructions_.size(); i++) {
            const auto& [op, words] = instructions_[i];
            if (op == FUNCTION) {
                globalsEnd_ = std::min(globalsEnd_, i);
                functionOf_.at(words[2]) = static_cast<uint32_t>(functions_.size());
                functions_.push_back({i, instructions_.size(), {}});
            } else if (op == LABEL) {
                if (functions_.empty()) throw std::invalid_argument("a SPIR-V module with a block outside all functions");
                auto& blocks = functions_.back().blocks;
                blockOf_.at(words[1]) = static_cast<uint32_t>(blocks.size());
                blocks.push_back({words[1], i + 1, i + 1, false, {}});
            } else if (op == FUNCTION_END && !functions_.empty()) {
                functions_.back().end = i + 1;
            } else if (!functions_.empty() && !functions_.back().blocks.empty()) {
                functions_.back().blocks.back().end = i + 1;
            }
        }
    }

    bool isWord(uint32_t type) const { return type == bool_ || std::ranges::find(ints_, type) != ints_.end(); }

    void learnGlobal(const Instruction& i) {
        const auto& words = i.words;
        switch (i.op) {
            case ENTRY_POINT: reach(words[2]); break;
            case TYPE_BOOL: bool_ = words[1]; break;
            case TYPE_INT:
                if (words[2] == 32) ints_.push_back(words[1]);
                break;
            case DECORATE:
                if (words[2] == SPEC_ID) specIds_.at(words[1]) = words[3];
                break;
            case CONSTANT_TRUE:
            case CONSTANT_FALSE: known_.at(words[2]) = Known::one(i.op == CONSTANT_TRUE); break;
            case SPEC_CONSTANT_TRUE:
            case SPEC_CONSTANT_FALSE: known_.at(words[2]) = Known::one(given(words[2], i.op == SPEC_CONSTANT_TRUE) != 0); break;
            case CONSTANT:
            case SPEC_CONSTANT:
                if (words.size() == 4) known_.at(words[2]) = Known::one(given(words[2], words[3]));
                break;
            case SPEC_CONSTANT_OP: known_.at(words[2]) = valueOf(words[3], words[1], words.subspan(4)); break;
            default: break;
        }
    }

    /// Of a global that is no known word any value may come; of the results of functions nothing is known yet.
    void forgetUnknown() {
        for (Known& k : known_) {
            if (k.state == Known::NOT_YET) k = Known::any();
        }
        for (size_t i = globalsEnd_; i < instructions_.size(); i++) {
            const auto& [op, words] = instructions_[i];
            if (op != FUNCTION_PARAMETER && !withoutResult(op) && words.size() > 2) known_.at(words[2]) = {};
        }
    }

    /// The word of a specialisation constant.
    uint32_t given(uint32_t id, uint32_t byDefault) const {
        return specIds_.at(id) < constants_.size() ? constants_[specIds_[id]] : byDefault;
    }

    Known valueOf(uint32_t op, uint32_t type, std::span<const uint32_t> operands) const {
        if (!isWord(type) || operands.empty()) return Known::any();
        const Known a = known_.at(operands[0]);
        if (op == SELECT && operands.size() == 3) {
            return a.state == Known::ONE ? known_.at(operands[a.value != 0 ? 1 : 2]) : a;
        }
        if (operands.size() > 2 || !computed(op, 0, 0)) return Known::any();
        const Known b = operands.size() == 2 ? known_.at(operands[1]) : Known::one(0);
        const bool both = op == LOGICAL_AND || op == BITWISE_AND;
        if (both && (a.is(0) || b.is(0))) return Known::one(0);
        if (op == LOGICAL_OR && (a.is(1) || b.is(1))) return Known::one(1);
        if (a.state == Known::ANY || b.state == Known::ANY) return Known::any();
        if (a.state == Known::NOT_YET || b.state == Known::NOT_YET) return {};
        const auto value = computed(op, a.value, b.value);
        return value ? Known::one(*value) : Known::any();
    }

    void reach(uint32_t function) {
        const uint32_t index = functionOf_.at(function);
        if (index == NONE) throw std::invalid_argument("a SPIR-V module that calls what is no function");
        if (functions_[index].live) return;
        functions_[index].live = true;
        waiting_.push_back(index);
    }

    /// Finds what blocks of a function are reached, and with it the functions that they call.
    void follow(Function& function) {
        if (function.blocks.empty()) return;
        function.blocks[0].live = true;
        do {
            changed_ = false;
            for (Block& block : function.blocks) {
                if (block.live) follow(function, block);
            }
        } while (changed_);
        for (const Block& block : function.blocks) {
            for (size_t i = block.first; block.live && i < block.end; i++) {
                const auto& [op, words] = instructions_[i];
                if (op == FUNCTION_CALL) reach(words[3]);
                if (op == LOOP_MERGE || (op == SELECTION_MERGE && staysOpen(block))) keep(function, block, words);
            }
        }
    }

    /// A block that ends with a question whose answer isn't known.
    bool staysOpen(const Block& block) const { return instructions_[block.end - 1].op == SWITCH || block.next.size() > 1; }

    /// The blocks that a merge instruction names have to be there.
    void keep(Function& function, const Block& head, std::span<const uint32_t> merge) {
        Block& after = blockIn(function, merge[1]);
        if (!after.live) after.keepsLabel = true;
        if (merge.size() < 4) return;  // no loop's
        Block& end = blockIn(function, merge[2]);
        if (!end.live) end.backTo = head.label;
    }

    Block& blockIn(Function& function, uint32_t label) const {
        const uint32_t index = blockOf_.at(label);
        if (index >= function.blocks.size()) throw std::invalid_argument("a SPIR-V module that goes on to what is no block");
        return function.blocks[index];
    }

    void follow(Function& function, Block& block) {
        for (size_t i = block.first; i < block.end; i++) {
            const auto& [op, words] = instructions_[i];
            if (op == BRANCH) {
                goOn(function, block, words[1]);
            } else if (op == BRANCH_CONDITIONAL) {
                // A loop keeps its way back, also where it is never gone.
                const bool loops = isBefore(block, words[2]) || isBefore(block, words[3]);
                const Known asked = loops ? Known::any() : known_.at(words[1]);
                if (asked.state == Known::ANY || asked.is(1)) goOn(function, block, words[2]);
                if (asked.state == Known::ANY || asked.is(0)) goOn(function, block, words[3]);
            } else if (op == SWITCH) {
                for (size_t w = 2; w < words.size(); w += 2) goOn(function, block, words[w]);
            } else if (!withoutResult(op) && words.size() > 2) {
                fall(words[2], op == PHI ? met(function, block, words) : valueOf(op, words[1], words.subspan(3)));
            }
        }
    }

    bool isBefore(const Block& block, uint32_t label) const { return blockOf_.at(label) <= blockOf_.at(block.label); }

    void goOn(Function& function, Block& block, uint32_t label) {
        if (std::ranges::find(block.next, label) != block.next.end()) return;
        block.next.push_back(label);
        blockIn(function, label).live = true;
        changed_ = true;
    }

    void fall(uint32_t id, Known now) {
        Known& before = known_.at(id);
        if (before == now || before.state == Known::ANY) return;
        if (before.state == Known::ONE) now = Known::any();
        before = now;
        changed_ = true;
    }

    /// What arrives at a phi by the ways that are open.
    Known met(Function& function, const Block& block, std::span<const uint32_t> words) const {
        if (!isWord(words[1])) return Known::any();
        Known all;
        for (size_t w = 3; w + 1 < words.size(); w += 2) {
            if (!isOpen(function, words[w + 1], block.label)) continue;
            const Known& k = known_.at(words[w]);
            if (k.state == Known::NOT_YET) continue;
            all = all.state == Known::NOT_YET || all == k ? k : Known::any();
        }
        return all;
    }

    bool isOpen(Function& function, uint32_t from, uint32_t to) const {
        const Block& block = blockIn(function, from);
        return block.live && std::ranges::find(block.next, to) != block.next.end();
    }

    /// Notes the results that are left out, whose names and decorations go too.
    void forgetDead(const Function& f) {
        const auto forget = [&](size_t i) {
            const auto& [op, words] = instructions_[i];
            if (!withoutResult(op) && words.size() > 1) gone_.at(op == LABEL ? words[1] : words[2]) = true;
        };
        if (!f.live) {
            for (size_t i = f.first; i < f.end; i++) forget(i);
            return;
        }
        for (const Block& block : f.blocks) {
            if (block.live) continue;
            if (!block.keepsLabel && block.backTo == 0) gone_.at(block.label) = true;
            for (size_t i = block.first; i < block.end; i++) forget(i);
        }
    }

    void put(uint32_t op, std::initializer_list<uint32_t> operands) {
        result_.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | op);
        result_.insert(result_.end(), operands);
    }
    void copy(std::span<const uint32_t> words) { result_.insert(result_.end(), words.begin(), words.end()); }

    void writeGlobal(const Instruction& i) {
        const auto& words = i.words;
        const bool aboutOne = i.op == NAME || i.op == DECORATE;
        if (aboutOne && gone_.at(words[1])) return;
        if (i.op == DECORATE && words[2] == SPEC_ID) return;
        const bool special =
            i.op == SPEC_CONSTANT_TRUE || i.op == SPEC_CONSTANT_FALSE || i.op == SPEC_CONSTANT || i.op == SPEC_CONSTANT_OP;
        if (!special || known_.at(words[2]).state != Known::ONE) return copy(words);
        const uint32_t value = known_[words[2]].value;
        if (words[1] == bool_) put(value != 0 ? CONSTANT_TRUE : CONSTANT_FALSE, {words[1], words[2]});
        else put(CONSTANT, {words[1], words[2], value});
    }

    void write(const Function& f) {
        const size_t head = f.blocks.empty() ? f.end : f.blocks[0].first - 1;
        for (size_t i = f.first; i < head; i++) copy(instructions_[i].words);
        if (f.blocks.empty()) return;
        for (const Block& block : f.blocks) {
            if (block.live) {
                put(LABEL, {block.label});
                for (size_t i = block.first; i < block.end; i++) write(f, block, instructions_[i]);
            } else if (block.backTo != 0) {
                put(LABEL, {block.label});
                put(BRANCH, {block.backTo});
            } else if (block.keepsLabel) {
                put(LABEL, {block.label});
                put(UNREACHABLE, {});
            }
        }
        put(FUNCTION_END, {});
    }

    void write(const Function& f, const Block& block, const Instruction& i) {
        const auto& words = i.words;
        if (i.op == PHI) return writePhi(f, block, words);
        if (i.op == SELECTION_MERGE && !staysOpen(block)) return;
        if (i.op == BRANCH_CONDITIONAL && block.next.size() == 1) return put(BRANCH, {block.next[0]});
        copy(words);
    }

    void writePhi(const Function& f, const Block& block, std::span<const uint32_t> words) {
        const size_t start = result_.size();
        copy(words.first(3));
        for (size_t w = 3; w + 1 < words.size(); w += 2) {
            const Block& from = f.blocks[blockOf_[words[w + 1]]];
            if (from.live && std::ranges::find(from.next, block.label) != from.next.end()) copy(words.subspan(w, 2));
            else if (from.backTo == block.label) result_.insert(result_.end(), {words[2], from.label});
        }
        result_[start] = static_cast<uint32_t>(result_.size() - start) << 16 | PHI;
    }

    static constexpr uint32_t NONE = 0xffffffffu;
    const std::span<const uint32_t> module_, constants_;
    std::vector<Instruction> instructions_;
    size_t globalsEnd_ = 0;
    std::vector<Function> functions_;
    std::vector<uint32_t> waiting_;  // functions that are reached and not followed
    std::vector<uint32_t> ints_;     // types of 32 bits
    uint32_t bool_ = 0;
    // By id.
    std::vector<Known> known_;
    std::vector<bool> gone_;
    std::vector<uint32_t> specIds_, functionOf_, blockOf_;
    bool changed_ = false;
    std::vector<uint32_t> result_;
};

}  // namespace

std::vector<uint32_t> specialised(std::span<const uint32_t> module, std::span<const uint32_t> constants) {
    return Specialiser(module, constants).written();
}

}  // namespace heliograph

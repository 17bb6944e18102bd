// Shaders without what their constants never reach.

#include "server/device/vulkan/core/spirv_specialised.h"
#include "server/device/vulkan/core/shader_code.h"
#include "server/device/vulkan/core/spirv_module.h"
#include "server/device/vulkan/core/spirv_uniforms.h"
#include "server/request/effects.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

namespace heliograph::TEST_FILE {
namespace {

using Words = std::vector<uint32_t>;

// Ids of the small modules below.
enum Id : uint32_t { VOID = 1, BOOL, WORD, SIGNATURE, A, B, ZERO, FIVE, YES, ASKED, MAIN, HELPER, UNUSED, FIRST_OWN };

/// A module with two specialisation constants, A (constant_id 0, a word, 3) and B (constant_id 1, a boolean, true), and the
/// functions MAIN, HELPER and UNUSED, whose instructions are given.
class Module {
public:
    Module() : words_{spirv::MAGIC, 0x00010500, 0, 100, 0} {
        put(17, {1});                           // Capability Shader
        put(14, {0, 1});                        // MemoryModel
        put(15, {5, MAIN, 0x6e69616d, 0});      // EntryPoint GLCompute "main"
        put(16, {MAIN, 17, 1, 1, 1});           // LocalSize
        put(5, {HELPER, 0x706c6568, 0});        // Name
        put(71, {A, 1, 0}).put(71, {B, 1, 1});  // SpecId
        put(19, {VOID}).put(20, {BOOL}).put(21, {WORD, 32, 0}).put(33, {SIGNATURE, VOID});
        put(50, {WORD, A, 3}).put(48, {BOOL, B});
        put(43, {WORD, ZERO, 0}).put(43, {WORD, FIVE, 5}).put(41, {BOOL, YES});
        put(52, {BOOL, ASKED, 171, A, ZERO});  // whether A has any bit
    }

    Module& put(uint32_t op, std::initializer_list<uint32_t> operands) {
        words_.push_back(static_cast<uint32_t>(operands.size() + 1) << 16 | op);
        words_.insert(words_.end(), operands);
        return *this;
    }
    Module& begin(uint32_t function) { return put(54, {VOID, function, 0, SIGNATURE}); }
    Module& end() { return put(56, {}); }
    Module& label(uint32_t id) { return put(248, {id}); }
    Module& call(uint32_t function, uint32_t result) { return put(57, {VOID, result, function}); }
    Module& back() { return put(253, {}); }
    /// Functions that do nothing.
    Module& others() {
        begin(HELPER).label(90).back().end();
        return begin(UNUSED).label(91).back().end();
    }
    const Words& words() const { return words_; }

private:
    Words words_;
};

/// How many instructions of each kind a module has.
std::map<uint32_t, size_t> counts(std::span<const uint32_t> module) {
    std::map<uint32_t, size_t> found;
    spirv::forEachInstruction(module, [&](uint32_t op, std::span<const uint32_t>) { found[op]++; });
    return found;
}

size_t functionsOf(std::span<const uint32_t> module) { return counts(module)[54]; }
size_t blocksOf(std::span<const uint32_t> module) { return counts(module)[248]; }

/// Whether spirv-val takes it; what it says is printed.
testing::AssertionResult isValid(const Words& module) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "specialised.spv";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(module.data()), static_cast<std::streamsize>(module.size() * sizeof(uint32_t)));
    const int code = std::system(("spirv-val --target-env vulkan1.2 " + file.string()).c_str());
    std::filesystem::remove(file);
    if (code == 0) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "spirv-val (of spirv-tools) ended with " << code;
}

/// main: if (`asked`) helper();
Words callsIf(uint32_t asked) {
    Module m;
    m.begin(MAIN).label(20).put(247, {22, 0}).put(250, {asked, 21, 22});
    m.label(21).call(HELPER, 30).put(249, {22}).label(22).back().end();
    return m.others().words();
}

TEST(Specialised, WhatIsNoModuleIsRefused) {
    EXPECT_THROW(specialised({}, {}), std::invalid_argument);
    Words broken = callsIf(ASKED);
    broken[0]++;
    EXPECT_THROW(specialised(broken, {}), std::invalid_argument);
    broken = callsIf(ASKED);
    broken.pop_back();
    broken.back() = 0x00050000 | 56;
    EXPECT_THROW(specialised(broken, {}), std::invalid_argument);
}

TEST(Specialised, ConstantsAreFixedAndTheirDefaultsHold) {
    const Words by = specialised(callsIf(ASKED), {});
    ASSERT_TRUE(isValid(by));
    EXPECT_EQ(counts(by)[50] + counts(by)[48] + counts(by)[52], 0u);
    EXPECT_EQ(counts(by)[71], 0u) << "no SpecId";
    EXPECT_EQ(functionsOf(by), 2u) << "main and helper";
    EXPECT_EQ(blocksOf(by), 4u);
    const uint32_t none[] = {0};
    const Words without = specialised(callsIf(ASKED), none);
    ASSERT_TRUE(isValid(without));
    EXPECT_EQ(functionsOf(without), 1u);
    EXPECT_EQ(blocksOf(without), 2u);
    EXPECT_EQ(counts(without)[5], 0u) << "the name of what is gone";
    EXPECT_EQ(counts(without)[247], 0u) << "a merge of nothing";
}

TEST(Specialised, BooleansAreSetByTheirWord) {
    const uint32_t off[] = {3, 0}, on[] = {3, 7};
    EXPECT_EQ(functionsOf(specialised(callsIf(B), off)), 1u);
    const Words there = specialised(callsIf(B), on);
    EXPECT_EQ(functionsOf(there), 2u);
    EXPECT_TRUE(isValid(there));
}

/// main: if (asked && b) helper(); as compilers write it, with a phi.
TEST(Specialised, AnAndOfWhatIsKnownAndWhatIsNotEndsWithTheFirst) {
    Module m;
    m.begin(MAIN).label(20).put(247, {22, 0}).put(250, {ASKED, 21, 22});
    m.label(21).put(168, {BOOL, 40, B}).put(249, {22});
    m.label(22).put(245, {BOOL, 41, ASKED, 20, 40, 21}).put(247, {24, 0}).put(250, {41, 23, 24});
    m.label(23).call(HELPER, 30).put(249, {24}).label(24).back().end();
    const Words module = m.others().words();
    const uint32_t neither[] = {0, 1}, both[] = {1, 0}, first[] = {1, 1};
    EXPECT_EQ(functionsOf(specialised(module, neither)), 1u);
    EXPECT_EQ(functionsOf(specialised(module, both)), 2u);
    EXPECT_EQ(functionsOf(specialised(module, first)), 1u);
    for (auto constants : {neither, both, first}) EXPECT_TRUE(isValid(specialised(module, {constants, 2})));
}

/// Of a loop that is left at once its end and what comes after it stay, as the merge instruction names them.
TEST(Specialised, ALoopThatIsLeftKeepsItsBlocks) {
    Module m;
    m.begin(MAIN).label(20).put(249, {21});
    m.label(21).put(246, {24, 23, 0}).put(249, {22});
    m.label(22).put(247, {26, 0}).put(250, {ASKED, 25, 26});
    m.label(25).back().label(26).put(249, {23});
    m.label(23).call(HELPER, 30).put(249, {21}).label(24).back().end();
    const Words module = m.others().words();
    const uint32_t on[] = {1}, off[] = {0};
    for (auto constants : {on, off}) ASSERT_TRUE(isValid(specialised(module, {constants, 1})));
    EXPECT_EQ(functionsOf(specialised(module, on)), 1u) << "the end of the loop is never reached";
    EXPECT_EQ(functionsOf(specialised(module, off)), 2u);
}

/// do helper(); while (false): a loop has one way back, or it is none.
TEST(Specialised, ALoopThatIsGoneThroughOnceKeepsItsWayBack) {
    Module m;
    m.begin(MAIN).label(20).put(249, {21});
    m.label(21).put(246, {24, 23, 0}).put(249, {22});
    m.label(22).call(HELPER, 30).put(249, {23});
    m.label(23).put(250, {ASKED, 21, 24}).label(24).back().end();
    const Words module = m.others().words();
    const uint32_t on[] = {1}, off[] = {0};
    for (auto constants : {on, off}) EXPECT_TRUE(isValid(specialised(module, {constants, 1})));
}

/// What goes round a loop is any value, although its first one is known.
TEST(Specialised, WhatALoopChangesIsNotKnown) {
    Module m;
    m.begin(MAIN).label(20).put(249, {21});
    m.label(21).put(245, {WORD, 40, ZERO, 20, 41, 23}).put(246, {24, 23, 0}).put(249, {22});
    m.label(22).put(170, {BOOL, 42, 40, FIVE}).put(247, {26, 0}).put(250, {42, 25, 26});
    m.label(25).call(HELPER, 30).put(249, {24}).label(26).put(249, {23});
    m.label(23).put(128, {WORD, 41, 40, FIVE}).put(249, {21}).label(24).back().end();
    const Words module = specialised(m.others().words(), {});
    EXPECT_EQ(functionsOf(module), 2u);
    EXPECT_TRUE(isValid(module));
}

/// The tracer and the preview, with all effects, none, and each alone.
TEST(Specialised, ShadersStayValidAndLoseWhatIsOff) {
    uint64_t all = 0;
    std::vector<uint64_t> sets{0};
    for (const EffectRow& row : effectRows()) {
        sets.push_back(row.bit);
        all |= row.bit;
    }
    sets.push_back(all);
    const size_t whole = shaders::traceWide4().size();
    for (uint64_t effects : sets) {
        SCOPED_TRACE(testing::Message() << "effects " << std::hex << effects);
        const uint32_t words[] = {static_cast<uint32_t>(effects), static_cast<uint32_t>(effects >> 32)};
        const uint32_t constants[] = {words[0], 4, 32, ~0u, 0, 0, words[1]};
        const Words tracer = specialised(shaders::traceWide4(), constants);
        ASSERT_TRUE(isValid(tracer));
        if (effects != all) {
            EXPECT_LT(tracer.size(), whole * 2 / 3);
        }
        ASSERT_TRUE(isValid(specialised(shaders::rasterFragment(), words)));
    }
    const uint32_t constants[] = {0, 4, 32, ~0u, 0, 0, 0};
    EXPECT_TRUE(isValid(specialised(shaders::traceWide2(), constants)));
    EXPECT_TRUE(isValid(specialised(shaders::rasterVertex(), constants)));
}

TEST(OpaqueUniforms, EveryNumberOfABlockIsReadOnce) {
    const auto count = [](const Words& module, uint32_t wanted) {
        uint32_t found = 0;
        spirv::forEachInstruction(module, [&](uint32_t op, std::span<const uint32_t>) { found += op == wanted; });
        return found;
    };
    constexpr uint32_t LOAD = 61, SHIFT_RIGHT = 194, BITWISE_OR = 197;
    const Words plain(shaders::traceWide4().begin(), shaders::traceWide4().end()), opaque = withOpaqueUniforms(plain);
    ASSERT_TRUE(isValid(opaque));
    const uint32_t reads = count(opaque, LOAD) - count(plain, LOAD);  // each reads the invocation's number, too
    EXPECT_GT(reads, 100u);
    EXPECT_EQ(count(opaque, SHIFT_RIGHT) - count(plain, SHIFT_RIGHT), reads);
    EXPECT_EQ(count(opaque, BITWISE_OR) - count(plain, BITWISE_OR), reads);
    EXPECT_TRUE(isValid(withOpaqueUniforms(shaders::traceWide2())));
    const Words vertex(shaders::rasterVertex().begin(), shaders::rasterVertex().end());
    EXPECT_EQ(withOpaqueUniforms(vertex), vertex) << "which has no invocations of that kind";
    EXPECT_THROW(withOpaqueUniforms(Words{1, 2, 3}), std::invalid_argument);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

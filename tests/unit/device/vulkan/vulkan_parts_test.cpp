// What the Vulkan device decides and prepares on the processor: trees, varieties, stacks, batches, SPIR-V.

#include "server/device/vulkan/core/spirv_exact.h"
#include "server/device/vulkan/trace/batch.h"
#include "server/device/vulkan/trace/gpu_scene.h"
#include "server/device/vulkan/tree/bvh_builder.h"
#include "server/scene/load/scene_source.h"

#include "tests/support/bodies.h"
#include "tests/support/sanitized.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>

namespace heliograph::TEST_FILE {
namespace {

/// Whether every triangle's corners lie in the boxes on the way to it, and each triangle is reached once.
void checkTree(const Bvh& bvh, uint32_t expected) {
    ASSERT_EQ(bvh.width, 4u);
    std::vector<uint32_t> seen(bvh.triangles.count / WORDS16_PER_TRIANGLE, 0);
    std::vector<uint32_t> stack{0};
    auto asFloat = [](uint32_t bits) {
        float x;
        std::memcpy(&x, &bits, 4);
        return x;
    };
    while (!stack.empty()) {
        const uvec4* node = bvh.nodes.data.get() + size_t(stack.back()) * WORDS16_PER_NODE;
        stack.pop_back();
        for (int child = 0; child < 4; child++) {
            uint32_t ref = node[3][child];
            if (ref < REF_TRIANGLES) {
                stack.push_back(ref);
                continue;
            }
            ASSERT_LT(ref, REF_INSTANCE);
            for (uint32_t i = ref & 0x07ffffffu, end = i + (ref >> 27 & 7u); i < end; i++) {
                seen[i]++;
                for (int axis = 0; axis < 3; axis++) {
                    float scale = asFloat((node[0].w >> (8 * axis) & 255u) << 23);
                    uint32_t lowWord = axis == 2 ? node[2].x : node[1][2 * axis];
                    uint32_t highWord = axis == 2 ? node[2].y : node[1][2 * axis + 1];
                    float low = asFloat(node[0][axis]) + scale * static_cast<float>(lowWord >> (8 * child) & 255u);
                    float high = asFloat(node[0][axis]) + scale * static_cast<float>(highWord >> (8 * child) & 255u);
                    for (int corner = 0; corner < 3; corner++) {
                        float x = asFloat(bvh.triangles.data[size_t(i) * 3 + corner][axis]);
                        ASSERT_LE(low, x);
                        ASSERT_GE(high, x);
                    }
                }
            }
        }
    }
    uint32_t once = 0;
    for (uint32_t n : seen) once += n == 1;
    EXPECT_EQ(once, expected);
}

TEST(Varieties, AreWhatTheScenesMaterialsTexturesAndImagesDo) {
    Scene scene;
    scene.environment.image = NO_INDEX;
    EXPECT_EQ(varietiesOf(scene), 0u);
    Material plain{};
    plain.baseTexture = plain.metallicRoughnessTexture = plain.normalTexture = plain.emissionTexture = plain.opacityTexture =
        plain.transmissionTexture = plain.specularTexture = plain.occlusionTexture = NO_INDEX;
    scene.materials = {plain};
    EXPECT_EQ(varietiesOf(scene), VARIETY_MICROFACET);
    scene.materials[0].flags = MATERIAL_UNLIT;
    EXPECT_EQ(varietiesOf(scene), VARIETY_UNLIT | VARIETY_PHONG);
    Material painted = plain;
    painted.flags = MATERIAL_PHONG | MATERIAL_BUMP;
    painted.baseTexture = painted.emissionTexture = 0;
    scene.materials = {painted};
    EXPECT_EQ(varietiesOf(scene), VARIETY_PHONG | VARIETY_BUMP | VARIETY_BASE_TEXTURE | VARIETY_EMISSION_TEXTURE);
    scene.materials.clear();
    TextureSlot slot{};
    slot.wrapV = WRAP_MIRROR;
    slot.nearest = 1;
    scene.textures = {slot};
    Image image{};
    image.format = IMAGE_RGB9E5;
    scene.images = {image};
    EXPECT_EQ(varietiesOf(scene), VARIETY_WRAP | VARIETY_NEAREST | VARIETY_SHARED_EXPONENT);
    scene.textures.clear();
    scene.images.clear();
    scene.environment.image = 0;
    EXPECT_EQ(varietiesOf(scene), VARIETY_WRAP);
}

TEST(BvhBuilder, QuantisedBoxesHoldTheirTriangles) {
    auto scene = openScene("cornell");
    BvhOptions options;
    options.width = 4;
    options.maxLeaf = 4;
    Bvh bvh = buildBvh(*scene, options);
    checkTree(bvh, static_cast<uint32_t>(bvh.triangles.count / WORDS16_PER_TRIANGLE));
    EXPECT_GE(bvh.stackDepth, 3u * 4u);
}

// A ray in the plane of a box's side is in the box, though its direction has no component across.
TEST(BvhBuilder, FloatBoxesHaveRoomAtEverySide) {
    SceneBuilder builder("boxes");
    builder.addInstance(builder.addMesh(test::box(vec3(0.0f), vec3(1.0f))), mat4(1.0f));
    const auto scene = builder.finish();
    BvhOptions options;
    options.width = 2;
    const Bvh bvh = buildBvh(*scene, options);
    ASSERT_GT(bvh.nodes.count, WORDS16_PER_NODE);
    const auto real = [](uint32_t word) { return std::bit_cast<float>(word); };
    for (size_t n = 0; n < bvh.nodes.count; n += WORDS16_PER_NODE) {
        const uvec4* node = bvh.nodes.data.get() + n;
        for (int i = 0; i < 2; i++) {
            const float lows[] = {real(node[i].x), real(node[i].z)}, highs[] = {real(node[i].y), real(node[i].w)};
            for (float low : lows) EXPECT_TRUE(low < 0.0f || (low > 0.5f && low < 1.0f)) << low;
            for (float high : highs) EXPECT_TRUE(high > 1.0f || (high > 0.0f && high < 0.5f)) << high;
        }
    }
}

TEST(PathStack, HoldsTheWorstBranchingAndNoMoreThanNeeded) {
    Settings settings;
    settings.maxReflections = 1;
    settings.maxRefractions = 8;
    EXPECT_EQ(pathStackSize(EffectSet{EFFECT_SHADOWS}, settings), 1u);
    EXPECT_EQ(pathStackSize(EffectSet{EFFECT_REFLECTIONS}, settings), 1u);
    // Eight refractions that each leave a reflection waiting, and the last pair.
    EXPECT_EQ(pathStackSize(EffectSet{EFFECT_REFLECTIONS | EFFECT_REFRACTIONS}, settings), 16u);
    EXPECT_EQ(pathStackSize(EffectSet{EFFECT_REFLECTIONS | EFFECT_REFRACTIONS | EFFECT_ALPHA_BLEND}, settings), 40u);
    EXPECT_EQ(pathStackSize(EffectSet{EFFECT_INDIRECT_LIGHT}, settings), 1u);
    EXPECT_EQ(pathStackSize(EffectSet{EFFECT_INDIRECT_LIGHT | EFFECT_GLOSSY_REFLECTIONS}, settings),
              pathStackSize(EffectSet{EFFECT_INDIRECT_LIGHT | EFFECT_REFLECTIONS}, settings));
    // Ten surfaces before the first bounce leave one each.
    EXPECT_EQ(pathStackSize(EffectSet{EFFECT_REFLECTIONS | EFFECT_REFRACTIONS | EFFECT_INDIRECT_LIGHT}, settings), 24u);
}

TEST(BatchSize, FollowsTheMeasuredRateWithinItsBounds) {
    BatchSize size{0.02, 1000, 100'000};
    EXPECT_EQ(size.samples(), 4000u);
    size.learn(0.01, 10'000);
    EXPECT_EQ(size.samples(), 20'000u);
    for (int i = 0; i < 50; i++) size.learn(1.0, 100);
    EXPECT_EQ(size.samples(), 1000u);
    for (int i = 0; i < 90; i++) size.learn(1e-6, 100'000);
    EXPECT_EQ(size.samples(), 100'000u);
    size.learn(1.0, 0);
    EXPECT_EQ(size.samples(), 100'000u);
}

// Words of a module: header, OpTypeFloat %2 32, OpFMul %2 %3 %4 %5.
TEST(SpirvExact, DecoratesArithmeticBeforeTheFirstType) {
    const uint32_t module[] = {0x07230203, 0x10500, 0, 9, 0, 3u << 16 | 22, 2, 32, 5u << 16 | 133, 2, 3, 4, 5};
    std::vector<uint32_t> exact = withoutContraction(module);
    ASSERT_EQ(exact.size(), std::size(module) + 3);
    EXPECT_EQ((std::vector<uint32_t>(exact.begin() + 5, exact.begin() + 8)), (std::vector<uint32_t>{3u << 16 | 71, 3, 42}));
    const uint32_t broken[] = {0x07230203, 0x10500, 0, 9, 0, 90u << 16 | 22};
    EXPECT_THROW(withoutContraction(broken), std::invalid_argument);
    const uint32_t other[] = {1, 2, 3, 4, 5, 6};
    EXPECT_THROW(withoutContraction(other), std::invalid_argument);
}

// Words of a module: import %1 "GLSL.std.450", OpTypeFloat %2 32, OpTypeVector %3 %2 4, OpFunction, OpFDiv of the type that
// is asked for, OpExtInst Sqrt.
std::vector<uint32_t> dividing(uint32_t type) {
    return {0x07230203,
            0x10500,
            0,
            20,
            0,
            6u << 16 | 11,
            1,
            0x4c534c47,
            0x6474732e,
            0x3035342e,
            0,
            3u << 16 | 22,
            2,
            32,
            4u << 16 | 23,
            3,
            2,
            4,
            5u << 16 | 54,
            10,
            11,
            0,
            12,
            5u << 16 | 136,
            type,
            4,
            5,
            6,
            6u << 16 | 12,
            2,
            7,
            1,
            31,
            4};
}

TEST(SpirvExact, QuotientsAndRootsKeepTheirIdsAndGetNewCode) {
    const std::vector<uint32_t> module = dividing(2), exact = withExactQuotients(module);
    std::vector<uint32_t> selects, constants;
    uint32_t divisions = 0, roots = 0, fused = 0;
    for (size_t at = 5; at < exact.size(); at += exact[at] >> 16) {
        ASSERT_NE(exact[at] >> 16, 0u);
        const uint32_t op = exact[at] & 0xffffu;
        if (op == 169) selects.push_back(exact[at + 2]);
        if (op == 43) constants.push_back(exact[at + 3]);
        divisions += op == 136;
        roots += op == 12 && exact[at + 4] == 31;
        fused += op == 12 && exact[at + 4] == 50;
    }
    EXPECT_EQ(selects, (std::vector<uint32_t>{4, 7})) << "what was the quotient's and the root's id";
    EXPECT_EQ(constants, (std::vector<uint32_t>{0x3f800000, 0x3f000000, 0x7e800000})) << "1, 1/2, 2^126";
    EXPECT_EQ(divisions, 2u) << "the driver's and the reciprocal";
    EXPECT_EQ(roots, 1u);
    EXPECT_EQ(fused, 4u + 5u);
    EXPECT_GT(exact[3], module[3]) << "the bound of ids";
    EXPECT_THROW(withExactQuotients(dividing(3)), std::invalid_argument) << "vectors";
    const uint32_t other[] = {1, 2, 3, 4, 5, 6};
    EXPECT_THROW(withExactQuotients(other), std::invalid_argument);
}

/// `x` moved by so many units in the last place.
float moved(float x, int ulps) { return std::bit_cast<float>(std::bit_cast<int32_t>(x) + ulps); }

// The recipe of withExactQuotients, in C++, from values that are off as far as drivers may be.
TEST(SpirvExact, TheRecipeRoundsToNearestFromAnErrorOfTwoUlp) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> mantissa(1.0f, 2.0f);
    std::uniform_int_distribution<int> exponent(-40, 40), error(-2, 2);
    for (uint32_t i = 0; i < test::repeated(10'000'000); i++) {
        const float a = std::ldexp(mantissa(random), exponent(random)), b = std::ldexp(mantissa(random), exponent(random));
        const float rough = moved(1.0f / b, error(random)), reciprocal = std::fma(std::fma(-b, rough, 1.0f), rough, rough);
        const float quotient = a * reciprocal;
        ASSERT_EQ(std::fma(std::fma(-b, quotient, a), reciprocal, quotient), a / b)
            << a << " / " << b << ", off by " << (rough - 1.0f / b);
        const float inverse = moved(static_cast<float>(1.0 / std::sqrt(double(a))), error(random));
        const float near = a * inverse, half = 0.5f * inverse, off = std::fma(-half, near, 0.5f);
        const float nearer = std::fma(near, off, near), halfInverse = std::fma(half, off, half);
        ASSERT_EQ(std::fma(std::fma(-nearer, nearer, a), halfInverse, nearer), std::sqrt(a)) << a;
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

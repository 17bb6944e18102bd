// The filter by itself, on pictures that are made here: what it must leave alone, and what it must gain.

#include "server/denoise/denoise_kernel.h"
#include "server/denoise/denoiser.h"
#include "server/kernel/instruction_set.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

namespace heliograph {

namespace lanes_v2 {
extern const DenoiseProgram DENOISE_PROGRAM;
}
namespace lanes_v3 {
extern const DenoiseProgram DENOISE_PROGRAM;
}
namespace lanes_v4 {
extern const DenoiseProgram DENOISE_PROGRAM;
}

namespace TEST_FILE {
namespace {

constexpr uint32_t UP = 1023u | 2047u << 11;  // the octahedron's code of (0, 1, 0), nearly

vec4 guide(uint32_t albedo, uint32_t normal, float nearness) {
    return {static_cast<float>(albedo), static_cast<float>(normal), nearness, 1.0f};
}

/// A wall of one colour at one distance, with light 1 and noise of this standard deviation.
DenoiseJob wall(uvec2 size, float noise, float variance, uint32_t seed = 1) {
    DenoiseJob job;
    job.size = size;
    std::mt19937 random(seed);
    std::normal_distribution<float> normal(0.0f, 1.0f);
    for (uint32_t i = 0; i < size.x * size.y; i++) {
        const float light = 1.0f + noise * normal(random);
        job.light.push_back(vec4(vec3(light), variance));
        job.guides.push_back(guide(0xffffff, UP, 0.5f));
    }
    return job;
}

double meanOf(const std::vector<vec4>& pixels) {
    double sum = 0.0;
    for (const vec4& p : pixels) sum += static_cast<double>(p.y);
    return sum / static_cast<double>(pixels.size());
}

double deviationOf(const std::vector<vec4>& pixels, double mean) {
    double sum = 0.0;
    for (const vec4& p : pixels) sum += (static_cast<double>(p.y) - mean) * (static_cast<double>(p.y) - mean);
    return std::sqrt(sum / static_cast<double>(pixels.size()));
}

void run(DenoiseJob& job) {
    ProcessorDenoiser denoiser;
    denoiser.run(job);
}

TEST(Denoiser, GrainOfOneSampleBecomesATenthAndTheMeanStays) {
    DenoiseJob job = wall({200, 120}, 0.3f, -1.0f);
    const double before = meanOf(job.light);
    run(job);
    EXPECT_NEAR(meanOf(job.light), before, 0.003);
    EXPECT_LT(deviationOf(job.light, 1.0), 0.03);
}

TEST(Denoiser, WhatSamplesAgreeOnStaysAsItIs) {
    DenoiseJob job = wall({64, 64}, 0.3f, 0.0f);  // no variance: what differs is no noise
    const std::vector<vec4> before = job.light;
    run(job);
    for (size_t i = 0; i < before.size(); i++)
        ASSERT_NEAR(job.light[i].x, before[i].x, 1e-5f * std::abs(before[i].x) + 1e-6f) << i;
}

TEST(Denoiser, RareBrightSamplesAreSpreadAndNotLost) {
    DenoiseJob job = wall({200, 120}, 0.0f, -1.0f);
    std::mt19937 random(7);
    for (vec4& p : job.light) p = random() % 20 == 0 ? vec4(20.0f, 20.0f, 20.0f, -1.0f) : vec4(0.0f, 0.0f, 0.0f, -1.0f);
    const double before = meanOf(job.light), grain = deviationOf(job.light, before);
    run(job);
    EXPECT_NEAR(meanOf(job.light) / before, 1.0, 0.03);
    EXPECT_LT(deviationOf(job.light, before), 0.25 * grain);
}

TEST(Denoiser, NothingPassesFromOneSurfaceToAnother) {
    // Left half: another colour, another normal, another distance, or nothing at all.
    const vec4 others[] = {guide(0x404040, 2047u | 1023u << 11, 0.5f), guide(0xffffff, UP, 0.4f), guide(0xffffff, 0, 0.0f)};
    for (const vec4& other : others) {
        DenoiseJob job = wall({64, 64}, 0.1f, -1.0f);
        for (uint32_t i = 0; i < 64 * 64; i++) {
            if (i % 64 >= 32) continue;
            job.light[i] *= vec4(9.0f, 9.0f, 9.0f, 1.0f);
            job.guides[i] = other;
        }
        run(job);
        double left = 0.0, right = 0.0;
        for (uint32_t y = 0; y < 64; y++) {
            left += static_cast<double>(job.light[y * 64 + 31].x) / 64;
            right += static_cast<double>(job.light[y * 64 + 32].x) / 64;
        }
        EXPECT_NEAR(left, 9.0, 0.3);
        EXPECT_NEAR(right, 1.0, 0.03);
    }
}

TEST(Denoiser, APlaneAtASlantIsOneSurface) {
    DenoiseJob job = wall({128, 128}, 0.3f, -1.0f);
    for (uint32_t y = 0; y < 128; y++)
        for (uint32_t x = 0; x < 128; x++)
            job.guides[y * 128 + x].z = 0.05f + 0.004f * x + 0.002f * y;  // twelve times as far at one end
    run(job);
    EXPECT_LT(deviationOf(job.light, 1.0), 0.05);
}

TEST(Denoiser, TexturesStay) {
    DenoiseJob job = wall({64, 64}, 0.2f, -1.0f);
    scalar_kernel::DenoiseKernel kernel;
    for (uint32_t i = 0; i < 64 * 64; i++) {
        const uint32_t colour = (i % 64 + i / 64) % 2 ? 0x3030ff : 0xe0e0a0;
        job.guides[i].x = static_cast<float>(colour);
        job.light[i] *= vec4(kernel.unpackedAlbedo(colour), 1.0f);
    }
    run(job);
    for (uint32_t i = 0; i < 64 * 64; i++) {
        const vec3 colour = kernel.unpackedAlbedo((i % 64 + i / 64) % 2 ? 0x3030ff : 0xe0e0a0);
        ASSERT_NEAR(job.light[i].x / colour.x, 1.0f, 0.15f) << i;
        ASSERT_NEAR(job.light[i].z / colour.z, 1.0f, 0.15f) << i;
    }
}

TEST(Denoiser, SharpPicturesInMirrorsAreNoGrain) {
    for (float variance : {-1.0f, 0.09f}) {
        DenoiseJob job = wall({64, 64}, 0.3f, variance);
        for (vec4& g : job.guides) g.y = static_cast<float>(UP | 3u << 22);
        const std::vector<vec4> before = job.light;
        run(job);
        for (size_t i = 0; i < before.size(); i++) ASSERT_NEAR(job.light[i].x, before[i].x, 1e-4f) << i;
    }
}

TEST(Denoiser, AnySizeAndAnyLightGivesNumbers) {
    ProcessorDenoiser denoiser;
    for (const uvec2 size : {uvec2(1, 1), uvec2(3, 200), uvec2(17, 1), uvec2(65, 33), uvec2(0, 0), uvec2(65, 33)}) {
        DenoiseJob job = wall(size, 0.3f, -1.0f);
        for (size_t i = 0; i < job.light.size(); i++) {
            if (i % 3 == 0) job.light[i] = vec4(3e38f, 0.0f, 1e30f, i % 2 ? -1.0f : 3e38f);
            if (i % 5 == 0) job.guides[i] = guide(0, 0, i % 2 ? 1e12f : 1e-30f);
        }
        denoiser.run(job);
        for (const vec4& p : job.light)
            ASSERT_TRUE(std::isfinite(p.x + p.y) && std::isfinite(p.z)) << size.x << " x " << size.y;
    }
}

// A slope that is taken from beyond the border must not make what lies there a neighbour.
TEST(Denoiser, WhatLiesOutsideThePictureCountsNothing) {
    DenoiseJob job = wall({1, 256}, 0.0f, -1.0f);
    for (size_t i = 0; i < 256; i++) {
        job.guides[i] = guide(0xffffff, 2047u | 1023u << 11, 0.5f);  // a normal along x
        job.light[i] = vec4(vec3(i % 2 ? 1.5f : 0.5f), -1.0f);
    }
    run(job);
    EXPECT_NEAR(meanOf(job.light), 1.0, 0.01);
}

TEST(Denoiser, EveryInstructionSetMakesTheSameBits) {
    std::vector<const DenoiseProgram*> programs{&lanes_v2::DENOISE_PROGRAM};
    if (processorRuns("v3")) programs.push_back(&lanes_v3::DENOISE_PROGRAM);
    if (processorRuns("v4")) programs.push_back(&lanes_v4::DENOISE_PROGRAM);
    ASSERT_STREQ(programs.front()->instructionSet, "v2");
    std::vector<vec4> first;
    for (const DenoiseProgram* program : programs) {
        DenoiseJob job = wall({83, 57}, 0.3f, -1.0f);
        for (uint32_t i = 0; i < job.guides.size(); i++) job.guides[i].z = 0.1f + 0.01f * static_cast<float>(i % 83);
        ProcessorDenoiser denoiser(*program);
        denoiser.run(job);
        if (first.empty()) first = job.light;
        ASSERT_EQ(std::memcmp(first.data(), job.light.data(), first.size() * sizeof(vec4)), 0) << program->instructionSet;
    }
}

TEST(Denoiser, NormalsComeBackFromTheirWords) {
    scalar_kernel::DenoiseKernel kernel;
    for (uint32_t x = 0; x <= 2047; x += 89) {
        for (uint32_t y = 0; y <= 2047; y += 89) {
            const vec3 n = kernel.unpackedNormal(x | y << 11);
            ASSERT_NEAR(glm::dot(n, n), 1.0f, 1e-5f);
        }
    }
    const vec3 up = kernel.unpackedNormal(UP);
    EXPECT_GT(up.y, 0.999f);
}

}  // namespace
}  // namespace TEST_FILE
}  // namespace heliograph

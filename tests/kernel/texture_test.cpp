#include "tests/kernel/kernel_access.h"

#include "server/scene/build/image_pyramid.h"

#include <gtest/gtest.h>

#include <array>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using glm::dvec2;
using glm::dvec4;

// Texels around every image that no sample may touch: full bright, while images stay under HIGHEST.
constexpr uint32_t GUARD = 0xffffffffu;
constexpr uint32_t HIGHEST = 200;

const EveryKernel::Ellipse POINT{};

/// A circle of that squared size about a point, as an ellipse, in both sets of coordinates.
EveryKernel::Ellipse circle(float area) {
    const float d = std::sqrt(area);
    return {vec4(d, 0.0f, d, 0.0f), vec4(0.0f, d, 0.0f, d)};
}

/// One image in a texel array of its own, guarded on both sides, behind texture slot 0.
struct OneTexture {
    std::vector<uint32_t> texels;
    ImageLevel level{};
    Image image{};
    TextureSlot slot{};
    EveryKernel kernel = bareKernel();

    OneTexture(uint32_t width, uint32_t height, uint32_t format, uint64_t seed) {
        Random random(seed);
        const uint32_t margin = 4 * width + 64;
        texels.assign(margin, GUARD);
        for (uint32_t i = 0; i < width * height; i++) {
            uint32_t word = 0;
            for (int c = 0; c < 4; c++) word |= random.below(HIGHEST + 1) << (8 * c);
            texels.push_back(word);
        }
        texels.insert(texels.end(), margin, GUARD);
        level.firstTexel = margin;
        level.width = width;
        level.height = height;
        image.levelCount = 1;
        image.format = format;
        slot.transform = vec4(1.0f, 0.0f, 0.0f, 1.0f);
    }
    OneTexture(const OneTexture&) = delete;

    vec4 sample(float u, float v, float area = 0.0f) {
        kernel.scene.texels = texels.data();
        kernel.scene.images = &image;
        kernel.scene.imageLevels = &level;
        kernel.scene.textures = &slot;
        return kernel.sampleTexture(0, vec2(u, v), vec2(0.0f), vec2(area), circle(area));
    }
    uint32_t word(int64_t x, int64_t y) const { return texels[level.firstTexel + y * level.width + x]; }
};

double decodeSrgb(double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); }
double encodeSrgb(double x) { return x <= 0.0031308 ? x * 12.92 : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055; }

double wrapped(double x, uint32_t mode) {
    if (!(std::abs(x) < 1e9)) return 0.0;
    if (mode == WRAP_CLAMP) return std::min(std::max(x, 0.0), 1.0);
    if (mode == WRAP_REPEAT) return x - std::floor(x);
    const double pair = x - 2.0 * std::floor(x / 2.0);
    return pair > 1.0 ? 2.0 - pair : pair;
}

int64_t outsideTexel(int64_t i, int64_t size, uint32_t mode) {
    if (mode == WRAP_REPEAT) return ((i % size) + size) % size;
    return std::min(std::max<int64_t>(i, 0), size - 1);  // mirrored: the neighbour across the border is the texel itself
}

dvec4 bilinear(const OneTexture& t, double u, double v) {
    const int64_t w = t.level.width, h = t.level.height;
    const double x = wrapped(u, t.slot.wrapU) * w - 0.5, y = wrapped(v, t.slot.wrapV) * h - 0.5;
    const double fx = std::floor(x), fy = std::floor(y);
    dvec4 sum(0.0);
    for (int j = 0; j < 2; j++) {
        for (int i = 0; i < 2; i++) {
            const uint32_t word =
                t.word(outsideTexel(int64_t(fx) + i, w, t.slot.wrapU), outsideTexel(int64_t(fy) + j, h, t.slot.wrapV));
            dvec4 texel;
            for (int c = 0; c < 4; c++) {
                const double code = (word >> (8 * c) & 255u) / 255.0;
                texel[c] = c < 3 && t.image.format == IMAGE_SRGB8 ? decodeSrgb(code) : code;
            }
            sum += texel * ((i ? x - fx : 1.0 - (x - fx)) * (j ? y - fy : 1.0 - (y - fy)));
        }
    }
    return sum;
}

double farthest(vec4 a, dvec4 b) {
    double worst = 0.0;
    for (int c = 0; c < 4; c++) worst = std::max(worst, std::abs(a[c] - b[c]));
    return worst;
}

TEST(Texture, SrgbToLinearIsWithinATenthOfACode) {
    EveryKernel kernel = bareKernel();
    double worst = 0.0;
    for (int code = 0; code < 256; code++) {
        const vec3 linear = kernel.srgbToLinear(vec3(float(code) / 255.0f));
        worst = std::max(worst, std::abs(encodeSrgb(linear.x) * 255.0 - code));
        EXPECT_EQ(linear.x, linear.y);
        EXPECT_EQ(linear.x, linear.z);
    }
    EXPECT_LE(worst, 0.11);
    EXPECT_EQ(kernel.srgbToLinear(vec3(0.0f)).x, 0.0f);
    EXPECT_NEAR(kernel.srgbToLinear(vec3(1.0f)).x, 1.0f, 1.2e-7f);
}

TEST(Texture, SrgbToLinearGrowsWithTheCode) {
    EveryKernel kernel = bareKernel();
    for (int code = 1; code < 256; code++)
        EXPECT_GT(kernel.srgbToLinear(vec3(float(code) / 255.0f)).x, kernel.srgbToLinear(vec3(float(code - 1) / 255.0f)).x)
            << code;
}

TEST(Texture, Rgb9e5IsDecodedExactly) {
    EveryKernel kernel = bareKernel();
    Random random(1);
    for (int i = 0; i < 100000; i++) {
        const uint32_t word = random.word();
        const vec4 texel = kernel.decodeTexel(word, IMAGE_RGB9E5);
        const double unit = std::ldexp(1.0, int(word >> 27) - 24);
        ASSERT_EQ(double(texel.x), (word & 511u) * unit);
        ASSERT_EQ(double(texel.y), (word >> 9 & 511u) * unit);
        ASSERT_EQ(double(texel.z), (word >> 18 & 511u) * unit);
        ASSERT_EQ(texel.w, 1.0f);
        ASSERT_EQ(unpackRgb9e5(word), vec3(texel.x, texel.y, texel.z)) << "the host's decoder agrees";
    }
}

TEST(Texture, LinearBytesAreDividedBy255) {
    EveryKernel kernel = bareKernel();
    const vec4 texel = kernel.decodeTexel(0xff804000u, IMAGE_LINEAR8);
    EXPECT_NEAR(texel.y, 64.0 / 255.0, 1e-7);
    EXPECT_NEAR(texel.z, 128.0 / 255.0, 1e-7);
    EXPECT_EQ(texel.x, 0.0f);
    EXPECT_NEAR(texel.w, 1.0, 1e-7);
}

TEST(Texture, WrapCoordinateIsExactArithmeticOnTheFloat) {
    EveryKernel kernel = bareKernel();
    Random random(2);
    for (uint32_t mode : {WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR}) {
        for (int i = 0; i < 100000; i++) {
            const auto x = static_cast<float>(random.magnitude(1e-6, 1e8) * (random.below(2) ? 1.0 : -1.0));
            const float y = kernel.wrapCoordinate(x, mode);
            ASSERT_TRUE(y >= 0.0f && y <= 1.0f) << x;
            ASSERT_NEAR(y, wrapped(x, mode), 6e-8) << x << " mode " << mode;
        }
    }
}

TEST(Texture, WrapCoordinateOfWhatIsNoUsableNumberIsZero) {
    EveryKernel kernel = bareKernel();
    for (uint32_t mode : {WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR})
        for (float x : {1e30f, -1e30f, 1e9f, INFINITE, -INFINITE, NOT_A_NUMBER, -0.0f})
            EXPECT_EQ(kernel.wrapCoordinate(x, mode), 0.0f) << x << " mode " << mode;
}

TEST(Texture, WrapCoordinateAtKnownPlaces) {
    EveryKernel kernel = bareKernel();
    EXPECT_EQ(kernel.wrapCoordinate(1e6f + 0.25f, WRAP_REPEAT), 0.25f);
    EXPECT_EQ(kernel.wrapCoordinate(-1e6f - 0.25f, WRAP_REPEAT), 0.75f);
    EXPECT_EQ(kernel.wrapCoordinate(1.25f, WRAP_MIRROR), 0.75f);
    EXPECT_EQ(kernel.wrapCoordinate(-0.25f, WRAP_MIRROR), 0.25f);
    EXPECT_EQ(kernel.wrapCoordinate(2.25f, WRAP_MIRROR), 0.25f);
    EXPECT_EQ(kernel.wrapCoordinate(7.0f, WRAP_CLAMP), 1.0f);
    EXPECT_EQ(kernel.wrapCoordinate(-7.0f, WRAP_CLAMP), 0.0f);
}

TEST(Texture, WrapTexelTakesTheNeighbourThatTheModeNames) {
    EveryKernel kernel = bareKernel();
    for (int size : {1, 2, 3, 7, 256})
        for (uint32_t mode : {WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR})
            for (int i = -1; i <= size; i++)
                EXPECT_EQ(kernel.wrapTexel(i, size, mode), outsideTexel(i, size, mode)) << i << " of " << size;
}

// Rounding of u * width moves the weights by up to 2^-24 * width; texels differ by up to 0.8.
TEST(Texture, BilinearFetchMatchesDouble) {
    Random random(3);
    const uvec2 sizes[] = {{1, 1}, {2, 2}, {3, 5}, {16, 16}, {17, 9}, {64, 1}};
    for (uvec2 size : sizes) {
        OneTexture texture(size.x, size.y, IMAGE_LINEAR8, size.x);
        for (uint32_t mode = 0; mode < 9; mode++) {
            texture.slot.wrapU = mode % 3;
            texture.slot.wrapV = mode / 3;
            double worst = 0.0;
            for (int i = 0; i < 4000; i++) {
                const float u = random.real(-3.0f, 3.0f), v = random.real(-1e4f, 1e4f);
                worst = std::max(worst, farthest(texture.sample(u, v), bilinear(texture, u, v)));
            }
            EXPECT_LT(worst, 2e-5) << size.x << "x" << size.y << " modes " << mode;
        }
    }
}

TEST(Texture, ColoursAreFilteredInLinearLight) {
    OneTexture texture(2, 1, IMAGE_SRGB8, 4);
    texture.texels[texture.level.firstTexel] = 0xff000000u;
    texture.texels[texture.level.firstTexel + 1] = 0xffffffffu;
    texture.slot.wrapU = WRAP_CLAMP;
    EXPECT_NEAR(texture.sample(0.5f, 0.5f).x, 0.5f, 1e-6f) << "half of the light, not code 128";
    Random random(5);
    OneTexture other(9, 7, IMAGE_SRGB8, 6);
    for (int i = 0; i < 4000; i++) {
        const float u = random.real(-2.0f, 2.0f), v = random.real(-2.0f, 2.0f);
        ASSERT_LT(farthest(other.sample(u, v), bilinear(other, u, v)), 1e-3);
    }
}

TEST(Texture, NearestTakesTheTexelThatHoldsThePoint) {
    Random random(7);
    for (uvec2 size : {uvec2(1, 1), uvec2(3, 5), uvec2(16, 8)}) {
        OneTexture texture(size.x, size.y, IMAGE_LINEAR8, size.y);
        texture.slot.nearest = 1;
        for (uint32_t mode : {WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR}) {
            texture.slot.wrapU = texture.slot.wrapV = mode;
            for (int i = 0; i < 10000; i++) {
                const float u = random.real(-1e4f, 1e4f), v = random.real(-2.0f, 2.0f);
                const double x = wrapped(u, mode) * size.x, y = wrapped(v, mode) * size.y;
                if (std::abs(x - std::round(x)) < 1e-5 || std::abs(y - std::round(y)) < 1e-5) continue;  // on a border
                const uint32_t word =
                    texture.word(std::min<int64_t>(int64_t(x), size.x - 1), std::min<int64_t>(int64_t(y), size.y - 1));
                ASSERT_NEAR(texture.sample(u, v).x, (word & 255u) / 255.0, 1e-7) << u << ' ' << v;
            }
        }
    }
}

TEST(Texture, NoCoordinateReadsOutsideTheImage) {
    std::vector<float> coordinates = {0.0f,   -0.0f,    1.0f,      -1.0f,        0.99999994f, 1.0000001f, -1e-10f,
                                      1e-40f, 1e6f,     -1e6f,     9.9e8f,       -9.9e8f,     1e9f,       1e30f,
                                      -1e30f, INFINITE, -INFINITE, NOT_A_NUMBER, 16777217.0f, 2.0f,       -2.0f};
    for (uvec2 size : {uvec2(1, 1), uvec2(2, 2), uvec2(5, 3), uvec2(1, 7), uvec2(16384, 1)}) {
        OneTexture texture(size.x, size.y, IMAGE_LINEAR8, 11);
        for (uint32_t mode = 0; mode < 18; mode++) {
            texture.slot.wrapU = mode % 3;
            texture.slot.wrapV = mode / 3 % 3;
            texture.slot.nearest = mode / 9;
            for (float u : coordinates) {
                for (float v : coordinates) {
                    const vec4 texel = texture.sample(u, v);
                    for (int c = 0; c < 4; c++)
                        ASSERT_TRUE(texel[c] >= 0.0f && texel[c] <= (HIGHEST + 0.1f) / 255.0f)
                            << u << ' ' << v << " in " << size.x << "x" << size.y << " modes " << mode;
                }
            }
        }
    }
}

TEST(Texture, TransformMovesScalesAndTurnsTheCoordinates) {
    OneTexture texture(16, 16, IMAGE_LINEAR8, 12);
    const vec4 direct = texture.sample(0.3f, 0.7f);
    texture.slot.transform = vec4(0.0f, 1.0f, -1.0f, 0.0f);  // u' = v + 0.1, v' = -u + 0.9
    texture.slot.offset = vec2(0.1f, 0.9f);
    EXPECT_LT(farthest(texture.sample(0.2f, 0.2f), dvec4(direct)), 1e-5);
    texture.slot.transform = vec4(0.0f);
    texture.slot.offset = vec2(0.3f, 0.7f);
    for (float u : {0.0f, 5.0f, 1e30f, -3.0f}) EXPECT_EQ(texture.sample(u, u), direct) << "a scale of 0 shows one texel";
}

TEST(Texture, SecondCoordinatesAreTakenWhereTheSlotSaysSo) {
    OneTexture texture(16, 16, IMAGE_LINEAR8, 13);
    const vec4 expected = texture.sample(0.4f, 0.6f);
    texture.slot.uvSet = 1;
    EXPECT_EQ(texture.kernel.sampleTexture(0, vec2(0.9f, 0.1f), vec2(0.4f, 0.6f), vec2(0.0f), POINT), expected);
}

TEST(Texture, AMaterialWithoutTextureIsWhite) {
    OneTexture texture(2, 2, IMAGE_LINEAR8, 14);
    texture.sample(0.0f, 0.0f);
    EXPECT_EQ(texture.kernel.sampleTexture(NO_INDEX, vec2(0.3f), vec2(0.3f), vec2(0.0f), POINT), vec4(1.0f));
}

// Every level has one colour of its own, so the colour tells the level.
TEST(Texture, MipLevelFollowsTheFootprint) {
    std::vector<uint32_t> texels;
    std::vector<ImageLevel> levels;
    for (uint32_t i = 0, size = 256; size >= 1; i++, size /= 2) {
        ImageLevel level{};
        level.firstTexel = static_cast<uint32_t>(texels.size());
        level.width = level.height = size;
        levels.push_back(level);
        texels.insert(texels.end(), size * size, i * 10);
    }
    Image image{};
    image.levelCount = static_cast<uint32_t>(levels.size());
    image.format = IMAGE_LINEAR8;
    EveryKernel kernel = bareKernel();
    kernel.scene.texels = texels.data();
    kernel.scene.imageLevels = levels.data();
    kernel.scene.images = &image;
    const auto levelFor = [&](double area) {
        return std::lround(kernel.sampleImage(0, 0.4f, 0.6f, WRAP_REPEAT, WRAP_REPEAT, float(area)).x * 25.5);
    };
    for (double side = 0.01; side < 5000.0; side *= 1.07) {  // footprint in texels of the base level
        const double lod = std::min(std::max(std::log2(side), 0.0), 8.0);
        if (std::abs(lod - std::floor(lod) - 0.5) < 0.01) continue;  // log2Rough's error decides there
        EXPECT_EQ(levelFor(side * side / 65536.0), std::lround(lod)) << side << " texels";
    }
    EXPECT_EQ(levelFor(0.0), 0);
    EXPECT_EQ(levelFor(1e30), 8);
    EXPECT_EQ(levelFor(double(INFINITE)), 8);
    EXPECT_LE(levelFor(double(NOT_A_NUMBER)), 8) << "any level, but one of the pyramid";
}

// A cosine wave across an ellipse: what is left of it is what an even row over the long axis leaves, whichever way both lie.
TEST(Texture, AStretchedFootprintIsAveragedAlongItsLongAxis) {
    const uint32_t size = 64;
    OneTexture texture(size, size, IMAGE_LINEAR8, 15);
    for (uint32_t y = 0; y < size; y++)
        for (uint32_t x = 0; x < size; x++) {
            const double wave = 0.5 + 0.39 * std::cos(2.0 * EXACT_PI * (3.0 * x + 2.0 * y) / size);
            texture.texels[texture.level.firstTexel + y * size + x] =
                static_cast<uint32_t>(std::lround(wave * 255.0)) * 0x01010101u;
        }
    texture.sample(0.0f, 0.0f);
    const dvec2 wave(3.0, 2.0);
    for (double turn : {0.0, 20.0, 75.0, 130.0}) {
        for (double ratio : {1.0, 3.0, 10.0}) {
            const double angle = turn * EXACT_PI / 180.0;
            const dvec2 axis = dvec2(std::cos(angle), std::sin(angle)) * (ratio / size), side = dvec2(-axis.y, axis.x) / ratio;
            // Conjugate diameters of the same ellipse: (p + q) / sqrt 2 and (p - q) / sqrt 2.
            for (const auto& [p, q] :
                 {std::pair(axis, side), std::pair((axis + side) * std::sqrt(0.5), (axis - side) * std::sqrt(0.5))}) {
                const EveryKernel::Ellipse e{vec4(p.x, p.y, 9.0f, 9.0f), vec4(q.x, q.y, 9.0f, 9.0f)};
                double crest = 0.0, trough = 1.0, exact = 0.0;
                const int taps = static_cast<int>(ratio);
                for (int i = 0; i < taps; i++)
                    exact += std::cos(2.0 * EXACT_PI * glm::dot(wave, axis) * ((i + 0.5) / taps - 0.5)) / taps;
                for (double along = 0.0; along < 1.0; along += 1.0 / 48.0) {
                    const float got = texture.kernel.sampleTexture(0, vec2(along / 3.0, 0.3f), vec2(0.0f), vec2(0.0f), e).x;
                    crest = std::max(crest, double(got)), trough = std::min(trough, double(got));
                }
                EXPECT_NEAR((crest - trough) / 0.78, std::abs(exact), 0.03) << turn << " degrees, ratio " << ratio;
            }
        }
    }
}

// The short axis chooses the level, unless the long one is more than MAX_TAPS times as long.
TEST(Texture, TheShortAxisChoosesTheLevel) {
    std::vector<uint32_t> texels;
    std::vector<ImageLevel> levels;
    for (uint32_t i = 0, size = 256; size >= 1; i++, size /= 2) {
        levels.push_back({static_cast<uint32_t>(texels.size()), size, size, 0});
        texels.insert(texels.end(), size * size, i * 10);
    }
    Image image{};
    image.levelCount = static_cast<uint32_t>(levels.size());
    image.format = IMAGE_LINEAR8;
    EveryKernel kernel = bareKernel();
    kernel.scene.texels = texels.data();
    kernel.scene.imageLevels = levels.data();
    kernel.scene.images = &image;
    const auto levelFor = [&](vec2 p, vec2 q) {
        return std::lround(kernel.sampleImageAlong(0, 0.4f, 0.6f, WRAP_REPEAT, WRAP_REPEAT, p / 256.0f, q / 256.0f).x * 25.5);
    };
    EXPECT_EQ(levelFor({0.0f, 0.0f}, {0.0f, 0.0f}), 0);
    EXPECT_EQ(levelFor({8.0f, 0.0f}, {0.0f, 1.0f}), 0);
    EXPECT_EQ(levelFor({0.0f, 8.0f}, {4.0f, 0.0f}), 2);
    EXPECT_EQ(levelFor({60.0f, 60.0f}, {-4.0f, 4.0f}), 2) << "short axis 5.7 long, the other 15 times that";
    EXPECT_EQ(levelFor({128.0f, 0.0f}, {0.0f, 1.0f}), 3) << "128 texels are no more than 16 samples";
    EXPECT_EQ(levelFor({1e30f, 0.0f}, {0.0f, 1e30f}), 8);
    EXPECT_EQ(levelFor({INFINITE, INFINITE}, {INFINITE, 0.0f}), 8);
    EXPECT_LE(levelFor({NOT_A_NUMBER, 0.0f}, {0.0f, NOT_A_NUMBER}), 8) << "any level, but one of the pyramid";
}

}  // namespace
}  // namespace heliograph::TEST_FILE

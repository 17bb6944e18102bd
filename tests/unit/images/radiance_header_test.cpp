#include "server/images/radiance_header.h"
#include "server/base/error.h"
#include "server/scene/load/image_loader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

namespace heliograph::TEST_FILE {
namespace {

using ::testing::HasSubstr;
using Rgb = std::array<float, 3>;

constexpr uint32_t WIDTH = 5, HEIGHT = 3;

/// The picture that every file below shows: each pixel is itself, exact in RGBE.
Rgb pixel(uint32_t x, uint32_t y) { return {float(x + 1) / 8.0f, float(y + 1) / 8.0f, 1.0f}; }

std::string rgbe(const Rgb& c) {
    int exponent = 0;
    const float most = std::max({c[0], c[1], c[2]});
    const float scale = std::frexp(most, &exponent) * 256.0f / most;
    std::string bytes;
    for (const float v : c) bytes += static_cast<char>(static_cast<uint8_t>(v * scale));
    return bytes + static_cast<char>(exponent + 128);
}

/// A file of `lines` x `perLine` pixels without runs.
std::string file(const std::string& variables, const std::string& sizes, uint32_t lines, uint32_t perLine,
                 const std::function<Rgb(uint32_t line, uint32_t at)>& stored) {
    std::string bytes = "#?RADIANCE\n" + variables + "\n" + sizes + "\n";
    for (uint32_t line = 0; line < lines; line++) {
        for (uint32_t at = 0; at < perLine; at++) bytes += rgbe(stored(line, at));
    }
    return bytes;
}

std::span<const uint8_t> bytesOf(const std::string& text) {
    return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

void expectPicture(const std::string& bytes, float tolerance = 0.0f) {
    const ImageInfo info = inspectImage(bytesOf(bytes), "sky.hdr");
    const ImageData image = decodeImage(bytesOf(bytes), "sky.hdr", true);
    ASSERT_EQ(image.width, WIDTH);
    ASSERT_EQ(image.height, HEIGHT);
    EXPECT_EQ(info.width, WIDTH);
    EXPECT_EQ(info.height, HEIGHT);
    for (uint32_t y = 0; y < HEIGHT; y++) {
        for (uint32_t x = 0; x < WIDTH; x++) {
            for (size_t c = 0; c < 3; c++)
                ASSERT_NEAR(image.rgb32f[(y * WIDTH + x) * 3 + c], pixel(x, y)[c], tolerance) << x << ' ' << y << ' ' << c;
        }
    }
}

const std::string RGB = "FORMAT=32-bit_rle_rgbe\n";

TEST(RadianceHeader, PixelsAreTurnedUpright) {
    for (const char* y : {"-Y", "+Y"}) {
        for (const char* x : {"+X", "-X"}) {
            SCOPED_TRACE(std::string(y) + x);
            const auto at = [&](uint32_t column, uint32_t row) {
                return pixel(*x == '-' ? WIDTH - 1 - column : column, *y == '+' ? HEIGHT - 1 - row : row);
            };
            expectPicture(file(RGB, std::string(y) + " 3 " + x + " 5", HEIGHT, WIDTH,
                               [&](uint32_t row, uint32_t column) { return at(column, row); }));
            expectPicture(file(RGB, std::string(x) + " 5 " + y + " 3", WIDTH, HEIGHT,
                               [&](uint32_t column, uint32_t row) { return at(column, row); }));
        }
    }
}

TEST(RadianceHeader, ExposuresAreTakenBack) {
    const auto brighter = [](uint32_t y, uint32_t x) {
        Rgb c = pixel(x, y);
        for (float& v : c) v *= 8.0f;
        return c;
    };
    expectPicture(file("EXPOSURE=2.0\nEXPOSURE= 4\n" + RGB, "-Y 3 +X 5", HEIGHT, WIDTH, brighter));
    for (const char* wrong : {"0", "-1", "bright", "inf", "nan"}) {
        try {
            decodeImage(bytesOf(file("EXPOSURE=" + std::string(wrong) + "\n" + RGB, "-Y 3 +X 5", HEIGHT, WIDTH, brighter)),
                        "sky.hdr", true);
            ADD_FAILURE() << wrong;
        } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr("EXPOSURE=" + std::string(wrong) + "; a number above 0"));
        }
    }
}

TEST(RadianceHeader, XyzBecomesRgb) {
    const auto xyz = [](uint32_t y, uint32_t x) {
        const Rgb c = pixel(x, y);
        return Rgb{0.5141f * c[0] + 0.3239f * c[1] + 0.1620f * c[2], 0.2651f * c[0] + 0.6702f * c[1] + 0.0647f * c[2],
                   0.0241f * c[0] + 0.1228f * c[1] + 0.8531f * c[2]};
    };
    expectPicture(file("FORMAT=32-bit_rle_xyze\n", "-Y 3 +X 5", HEIGHT, WIDTH, xyz), 0.02f);
}

TEST(RadianceHeader, OldRunsAreRead) {
    // One row of 300 equal pixels and one other: a run of 43 + 1 x 256, then the pixel.
    const Rgb grey{0.5f, 0.5f, 0.5f}, white{1, 1, 1};
    std::string bytes = "#?RADIANCE\n" + RGB + "\n-Y 1 +X 301\n" + rgbe(grey);
    bytes += std::string("\1\1\1", 3) + char(43) + std::string("\1\1\1\1", 4) + rgbe(white);
    const ImageData image = decodeImage(bytesOf(bytes), "sky.hdr", true);
    ASSERT_EQ(image.rgb32f.size(), 301u * 3);
    EXPECT_EQ(image.rgb32f[299 * 3], 0.5f);
    EXPECT_EQ(image.rgb32f[300 * 3], 1.0f);
}

TEST(RadianceHeader, DamagedFilesAreRefusedAndHarmNothing) {
    const std::string whole = file(RGB, "-Y 3 +X 5", HEIGHT, WIDTH, [](uint32_t y, uint32_t x) { return pixel(x, y); });
    for (size_t length = 11; length + 1 < whole.size(); length++)
        EXPECT_THROW(decodeImage(bytesOf(whole.substr(0, length)), "sky.hdr", true), InputError) << length;
    for (const char* sizes : {"-Y 3 -Y 5", "Y 3 X 5", "-Y 0 +X 5", "-Y 3", "-Y 99999 +X 99999", "-Y 3 +X 5 more", ""})
        EXPECT_THROW(decodeImage(bytesOf(file(RGB, sizes, 3, 5,
                                              [](uint32_t, uint32_t) {
                                                  return Rgb{1, 1, 1};
                                              })),
                                 "sky.hdr", true),
                     InputError)
            << sizes;
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "server/base/error.h"
#include "server/scene/load/image_loader.h"

#include <gtest/gtest.h>
#include <webp/encode.h>

namespace heliograph::TEST_FILE {
namespace {

/// A picture of one colour, without loss.
std::vector<uint8_t> webp(int channels, const std::vector<uint8_t>& color) {
    std::vector<uint8_t> pixels;
    for (int i = 0; i < 32 * 16; i++) pixels.insert(pixels.end(), color.begin(), color.end());
    uint8_t* bytes = nullptr;
    const size_t size = channels == 4 ? WebPEncodeLosslessRGBA(pixels.data(), 32, 16, 32 * 4, &bytes)
                                      : WebPEncodeLosslessRGB(pixels.data(), 32, 16, 32 * 3, &bytes);
    const std::vector<uint8_t> file(bytes, bytes + size);
    WebPFree(bytes);
    return file;
}

TEST(WebP, IsReadWithAndWithoutAlpha) {
    for (const int channels : {3, 4}) {
        SCOPED_TRACE(channels);
        const std::vector<uint8_t> file =
            webp(channels, channels == 3 ? std::vector<uint8_t>{200, 100, 50} : std::vector<uint8_t>{200, 100, 50, 128});
        const ImageData image = decodeImage(file, "picture.webp", true);
        ASSERT_EQ(image.width, 32u);
        ASSERT_EQ(image.height, 16u);
        ASSERT_EQ(image.rgba8.size(), 32u * 16 * 4);
        EXPECT_TRUE(image.srgb);
        for (size_t i = 0; i < image.rgba8.size(); i += 4) {
            ASSERT_EQ(image.rgba8[i], 200);
            ASSERT_EQ(image.rgba8[i + 1], 100);
            ASSERT_EQ(image.rgba8[i + 2], 50);
            ASSERT_EQ(image.rgba8[i + 3], channels == 3 ? 255 : 128);  // multiplies nothing
        }
    }
}

TEST(WebP, TruncationsAreRefused) {
    const std::vector<uint8_t> file = webp(3, {200, 100, 50});
    for (size_t length = 0; length + 2 < file.size(); length++)
        EXPECT_THROW(decodeImage(std::span(file).first(length), "picture.webp", true), InputError) << length;
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "server/encode/exr_encoder.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/jpeg_stripes.h"
#include "server/encode/png_encoder.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <cmath>

namespace heliograph::TEST_FILE {
namespace {

struct Decoded {
    int width = 0, height = 0, channels = 0;
    std::vector<float> values;  // 0..1 for 8-bit formats
    OIIO::ImageSpec spec;
    float at(int x, int y, int c) const { return values[static_cast<size_t>((y * width + x) * channels + c)]; }
};

/// Read by OpenImageIO, which none of the 8-bit encoders uses.
Decoded decoded(std::vector<uint8_t> bytes, const char* name) {
    OIIO::Filesystem::IOMemReader reader(bytes.data(), bytes.size());
    auto input = OIIO::ImageInput::open(name, nullptr, &reader);
    Decoded result;
    if (input == nullptr) {
        ADD_FAILURE() << OIIO::geterror();
        return result;
    }
    result.spec = input->spec();
    result.width = result.spec.width;
    result.height = result.spec.height;
    result.channels = result.spec.nchannels;
    result.values.resize(static_cast<size_t>(result.width * result.height * result.channels));
    EXPECT_TRUE(input->read_image(0, 0, 0, result.channels, OIIO::TypeDesc::FLOAT, result.values.data()));
    return result;
}

/// Smooth colours, and fine red-green stripes on the right half.
DisplayImage testImage(uint32_t width, uint32_t height) {
    DisplayImage image{width, height, {}};
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            bool stripes = x >= width / 2;
            auto red = static_cast<uint8_t>(stripes ? (x % 2 ? 230 : 30) : x * 255 / width);
            auto green = static_cast<uint8_t>(stripes ? (x % 2 ? 30 : 230) : y * 255 / height);
            image.rgba.insert(image.rgba.end(), {red, green, 100, static_cast<uint8_t>(x % 256)});
        }
    }
    return image;
}

double rms(const DisplayImage& image, const Decoded& other, int fromX, int toX) {
    double sum = 0.0;
    for (int y = 0; y < other.height; y++) {
        for (int x = fromX; x < toX; x++) {
            for (int c = 0; c < 3; c++) {
                size_t index = static_cast<size_t>(y * other.width + x) * 4 + static_cast<size_t>(c);
                double difference = image.rgba[index] / 255.0 - other.at(x, y, c);
                sum += difference * difference;
            }
        }
    }
    return std::sqrt(sum / (3.0 * other.height * (toX - fromX)));
}

TEST(PngEncoder, KeepsEveryPixel) {
    DisplayImage image = testImage(61, 37);
    std::vector<uint8_t> bytes;
    makePngEncoder()->encode(image, 0, bytes);
    Decoded back = decoded(bytes, "a.png");
    ASSERT_EQ(back.width, 61);
    ASSERT_EQ(back.height, 37);
    ASSERT_EQ(back.channels, 3) << "alpha is not stored";
    EXPECT_LT(rms(image, back, 0, 61), 1e-6);
    EXPECT_EQ(back.spec.get_string_attribute("oiio:ColorSpace"), "sRGB");
}

TEST(PngEncoder, EqualPicturesGiveEqualBytes) {
    DisplayImage image = testImage(200, 100);
    std::vector<uint8_t> first, second(7, 0xff);
    auto encoder = makePngEncoder();
    encoder->encode(image, 0, first);
    encoder->encode(image, 50, second);
    EXPECT_EQ(first, second);
    std::vector<uint8_t> third;
    makePngEncoder()->encode(image, 0, third);
    EXPECT_EQ(first, third);
}

TEST(PngEncoder, ThrowsForAPictureWithoutPixels) {
    std::vector<uint8_t> bytes;
    EXPECT_THROW(makePngEncoder()->encode({}, 0, bytes), std::runtime_error);
}

TEST(JpegEncoder, IsCloseAndCloserWithQuality) {
    DisplayImage image = testImage(160, 96);
    auto encoder = makeJpegEncoder();
    EXPECT_EQ(encoder->mimeType(), "image/jpeg");
    std::vector<uint8_t> coarse, fine;
    encoder->encode(image, 30, coarse);
    encoder->encode(image, 85, fine);
    EXPECT_LT(coarse.size(), fine.size());
    Decoded back = decoded(fine, "a.jpg");
    ASSERT_EQ(back.width, 160);
    ASSERT_EQ(back.height, 96);
    // The smooth half; 60 keeps clear of the blocks that the stripes reach into.
    EXPECT_LT(rms(image, back, 0, 60), 0.02);
    EXPECT_LT(rms(image, back, 0, 60), rms(image, decoded(coarse, "a.jpg"), 0, 60));
}

TEST(JpegEncoder, HalvesColourBelowQualityNinety) {
    DisplayImage image = testImage(160, 96);
    auto encoder = makeJpegEncoder();
    std::vector<uint8_t> halved, full;
    encoder->encode(image, 89, halved);
    encoder->encode(image, 90, full);
    // Stripes of one pixel whose brightness is equal: gone at half colour resolution, there at full.
    EXPECT_GT(rms(image, decoded(halved, "a.jpg"), 96, 160), 0.15);
    EXPECT_LT(rms(image, decoded(full, "a.jpg"), 96, 160), 0.05);
}

TEST(JpegEncoder, TakesSizesThatAreNoWholeBlocks) {
    auto encoder = makeJpegEncoder();
    for (auto [width, height] : {std::pair{1u, 1u}, {17u, 3u}, {640u, 1u}}) {
        std::vector<uint8_t> bytes;
        encoder->encode(testImage(width, height), 80, bytes);
        Decoded back = decoded(bytes, "a.jpg");
        EXPECT_EQ(back.width, static_cast<int>(width));
        EXPECT_EQ(back.height, static_cast<int>(height));
    }
    std::vector<uint8_t> bytes;
    EXPECT_THROW(encoder->encode({}, 80, bytes), std::runtime_error);
}

/// The whole picture by libjpeg-turbo in one piece.
std::vector<uint8_t> inOnePiece(const DisplayImage& image, int quality) {
    const bool fine = quality >= 90;
    const auto width = static_cast<int>(image.width), height = static_cast<int>(image.height);
    tjhandle handle = tjInitCompress();
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    EXPECT_EQ(tjCompress2(handle, image.rgba.data(), width, 4 * width, height, TJPF_RGBX, &bytes, &size,
                          fine ? TJSAMP_444 : TJSAMP_420, quality, fine ? TJFLAG_ACCURATEDCT : TJFLAG_FASTDCT),
              0);
    std::vector<uint8_t> result(bytes, bytes + size);
    tjFree(bytes);
    tjDestroy(handle);
    return result;
}

// Coded in stripes, by one thread or by all, a picture is the one that is coded in one piece, to the last code.
TEST(JpegEncoder, StripesMakeTheSamePicture) {
    for (uvec2 size : {uvec2(61, 37), uvec2(200, 64), uvec2(333, 65), uvec2(640, 360), uvec2(50, 1500)}) {
        const DisplayImage image = testImage(size.x, size.y);
        for (int quality : {40, 80, 95}) {
            std::vector<uint8_t> own, all;
            makeJpegEncoder(StripeThreads::own)->encode(image, static_cast<uint32_t>(quality), own);
            makeJpegEncoder(StripeThreads::all)->encode(image, static_cast<uint32_t>(quality), all);
            EXPECT_EQ(own, all);
            const Decoded stripes = decoded(own, "a.jpg"), whole = decoded(inOnePiece(image, quality), "a.jpg");
            ASSERT_EQ(stripes.width, whole.width);
            ASSERT_EQ(stripes.height, whole.height);
            EXPECT_EQ(stripes.values, whole.values) << size.x << "x" << size.y << " at " << quality;
        }
    }
}

TEST(JpegEncoder, StripesThatAreNoFilesAreRefused) {
    std::vector<uint8_t> file, bytes;
    makeJpegEncoder()->encode(testImage(64, 64), 80, file);
    for (size_t size : {size_t{0}, size_t{1}, size_t{3}, size_t{100}, file.size() - 1}) {
        const std::span<const uint8_t> cut(file.data(), size);
        EXPECT_THROW(joinStripes(std::span(&cut, 1), 64, 16, bytes), std::runtime_error) << size;
    }
}

TEST(ExrEncoder, KeepsEveryFloat) {
    uvec2 size(33, 18);
    std::vector<vec4> pixels;
    for (uint32_t i = 0; i < size.x * size.y; i++) {
        auto f = static_cast<float>(i);
        pixels.push_back(vec4(f * 1.1e-7f, f * 1000.1f, -f / 3.0f, 64.0f));
    }
    std::vector<uint8_t> bytes, again;
    encodeExr(pixels, size, bytes);
    encodeExr(pixels, size, again);
    EXPECT_EQ(bytes, again);
    Decoded back = decoded(bytes, "a.exr");
    ASSERT_EQ(back.width, 33);
    ASSERT_EQ(back.height, 18);
    ASSERT_EQ(back.channels, 3);
    for (int y = 0; y < 18; y++) {
        for (int x = 0; x < 33; x++) {
            const vec4& pixel = pixels[static_cast<size_t>(y * 33 + x)];
            EXPECT_EQ(vec3(back.at(x, y, 0), back.at(x, y, 1), back.at(x, y, 2)), vec3(pixel.x, pixel.y, pixel.z));
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

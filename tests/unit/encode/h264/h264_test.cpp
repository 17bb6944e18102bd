// Of builds with HELIOGRAPH_OPENH264 alone; ./check h264.

#include "server/encode/h264_encoder.h"

#include "tests/support/h264_decoder.h"
#include <gtest/gtest.h>

#include <stdexcept>

namespace heliograph::TEST_FILE {
namespace {

using test::difference, test::waves, test::yuvOf;

/// Types of the units of a picture in Annex B.
std::vector<int> unitsOf(const std::vector<uint8_t>& bytes) {
    std::vector<int> types;
    for (size_t i = 0; i + 3 < bytes.size(); i++)
        if (bytes[i] == 0 && bytes[i + 1] == 0 && bytes[i + 2] == 1) types.push_back(bytes[i + 3] & 31);
    return types;
}

const std::vector<int> KEY_UNITS = {7, 8, 5}, OTHER_UNITS = {1};  // SPS, PPS, one slice; one slice

TEST(H264Encoder, ADecoderSeesEveryPictureOfEverySize) {
    for (const auto& [width, height] :
         {std::pair(320u, 180u), {161u, 91u}, {322u, 178u}, {16u, 16u}, {17u, 16u}, {1u, 1u}, {7u, 50u}, {8192u, 18u}}) {
        const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
        test::H264Decoder decoder;
        std::vector<uint8_t> bytes;
        for (uint32_t time = 0; time < 6; time++) {
            const DisplayImage image = waves(width, height, time);
            encoder->encode(image, 80, bytes);
            EXPECT_EQ(encoder->key(), time == 0);
            EXPECT_EQ(unitsOf(bytes), time == 0 ? KEY_UNITS : OTHER_UNITS);
            EXPECT_LT(difference(decoder.decode(bytes, width, height), yuvOf(image)), 6.0)
                << width << " x " << height << ", picture " << time;
            EXPECT_EQ(decoder.codedWidth, std::max(width + width % 2, 16u));
            EXPECT_EQ(decoder.codedHeight, std::max(height + height % 2, 16u));
        }
    }
}

TEST(H264Encoder, WhoCannotDecodeMoreIsToldSoByTheFirstBytes) {
    const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
    std::vector<uint8_t> bytes;
    encoder->encode(waves(1280, 720, 0), 80, bytes);
    ASSERT_GT(bytes.size(), 8u);
    EXPECT_EQ(bytes[4] & 31, 7) << "the sequence's parameters";
    EXPECT_EQ(bytes[5], 66) << "baseline";
    EXPECT_EQ(bytes[6] & 0x40, 0x40) << "constrained";
    EXPECT_LE(bytes[7], 52) << "level";
}

TEST(H264Encoder, PicturesThatBuildOnOthersAreSmaller) {
    const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
    std::vector<uint8_t> first, second, fine;
    encoder->encode(waves(320, 180, 0), 50, first);
    encoder->encode(waves(320, 180, 1), 50, second);
    EXPECT_LT(2 * second.size(), first.size());
    encoder->wantKey();
    encoder->encode(waves(320, 180, 2), 95, fine);
    EXPECT_GT(fine.size(), first.size()) << "the quality counts for each picture";
}

TEST(H264Encoder, AnotherQualityTakesNoKeyPicture) {
    const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
    test::H264Decoder decoder;
    std::vector<uint8_t> bytes;
    std::vector<double> off;
    uint32_t time = 0;
    for (const uint32_t quality : {80, 20, 20, 95, 95, 50}) {
        const DisplayImage image = waves(320, 180, time++);
        encoder->encode(image, quality, bytes);
        EXPECT_EQ(encoder->key(), time == 1) << quality;
        off.push_back(difference(decoder.decode(bytes, 320, 180), yuvOf(image)));
    }
    EXPECT_GT(off[2], 1.2 * off[0]);
    EXPECT_LT(off[4], 0.8 * off[2]);
}

TEST(H264Encoder, AKeyPictureNeedsNoneBefore) {
    const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
    std::vector<uint8_t> bytes;
    for (uint32_t time = 0; time < 3; time++) encoder->encode(waves(160, 90, time), 80, bytes);
    test::H264Decoder late;
    EXPECT_EQ(late.decode(bytes, 160, 90).width, 0u) << "who joins cannot see this one";
    encoder->wantKey();
    for (uint32_t time = 3; time < 6; time++) {
        const DisplayImage image = waves(160, 90, time);
        encoder->encode(image, 80, bytes);
        EXPECT_EQ(encoder->key(), time == 3);
        EXPECT_LT(difference(late.decode(bytes, 160, 90), yuvOf(image)), 6.0) << time;
    }
}

TEST(H264Encoder, AnotherSizeBeginsWithAKeyPicture) {
    const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
    test::H264Decoder decoder;
    std::vector<uint8_t> bytes;
    uint32_t time = 0;
    for (const auto& [width, height] : {std::pair(160u, 90u), {320u, 180u}, {131u, 73u}}) {
        for (const bool key : {true, false}) {
            const DisplayImage image = waves(width, height, time++);
            encoder->encode(image, 80, bytes);
            EXPECT_EQ(encoder->key(), key) << width;
            EXPECT_LT(difference(decoder.decode(bytes, width, height), yuvOf(image)), 6.0) << width;
        }
    }
}

TEST(H264Encoder, RefusesWhatIsNoPictureAndGoesOn) {
    const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
    std::vector<uint8_t> bytes;
    EXPECT_THROW(encoder->encode({}, 80, bytes), std::runtime_error);
    EXPECT_THROW(encoder->encode({70'000, 1, std::vector<uint8_t>(280'000)}, 80, bytes), std::runtime_error);
    encoder->encode(waves(64, 48, 0), 80, bytes);
    EXPECT_TRUE(encoder->key());
}

TEST(H264Encoder, TakesAsManyPixelsAsItSays) {
    const std::unique_ptr<VideoEncoder> encoder = makeH264Encoder();
    std::vector<uint8_t> bytes;
    for (const auto& [width, height] : {std::pair(4096u, 2304u), {8192u, 1152u}}) {
        ASSERT_TRUE(h264Fits(width, height));
        EXPECT_FALSE(h264Fits(width + 1, height));
        EXPECT_FALSE(h264Fits(width, height + 1));
        const DisplayImage grey{width, height, std::vector<uint8_t>(size_t(width) * height * 4, 99)};
        test::H264Decoder decoder;
        for (int time = 0; time < 2; time++) {
            encoder->encode(grey, 80, bytes);
            EXPECT_LT(difference(decoder.decode(bytes, width, height), yuvOf(grey)), 1.0) << width << ", " << time;
        }
    }
}

TEST(H264Encoder, TheQuantizerFallsWithQuality) {
    for (uint32_t quality = 2; quality <= 100; quality++) EXPECT_LE(h264Quantizer(quality), h264Quantizer(quality - 1));
    EXPECT_LE(h264Quantizer(0), 51u);
    EXPECT_EQ(h264Quantizer(200), h264Quantizer(100));
}

TEST(VideoEncoder, ThisBuildMakesH264) {
    EXPECT_TRUE(videoBuilt(VideoCodec::h264));
    EXPECT_TRUE(videoFits(VideoCodec::h264, 1280, 720));
    EXPECT_FALSE(videoFits(VideoCodec::h264, 7680, 4320));
    EXPECT_EQ(makeVideoEncoder(VideoCodec::h264)->mimeType(), "video/h264");
    EXPECT_EQ(makeVideoEncoder(VideoCodec::vp9)->mimeType(), "video/vp9");
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "server/encode/vp9_encoder.h"

#include "tests/support/vp9_decoder.h"
#include <gtest/gtest.h>

#include <stdexcept>

namespace heliograph::TEST_FILE {
namespace {

using test::difference, test::waves, test::yuvOf;
using Decoder = test::Vp9Decoder;

TEST(Yuv, CodesAreThoseOfBt709) {
    const struct {
        uint8_t r, g, b, y, u, v;
    } known[] = {{0, 0, 0, 16, 128, 128},   {255, 255, 255, 235, 128, 128}, {77, 77, 77, 82, 128, 128},
                 {255, 0, 0, 63, 102, 240}, {0, 255, 0, 173, 42, 26},       {0, 0, 255, 32, 240, 118}};
    for (const auto& k : known) {
        DisplayImage image{3, 3, {}};
        for (int i = 0; i < 9; i++) image.rgba.insert(image.rgba.end(), {k.r, k.g, k.b, 255});
        const YuvImage yuv = yuvOf(image);
        ASSERT_EQ(yuv.y.size(), 9u);
        ASSERT_EQ(yuv.u.size(), 4u) << "odd sizes are rounded up";
        for (const uint8_t code : yuv.y) EXPECT_NEAR(code, k.y, 1);
        for (const uint8_t code : yuv.u) EXPECT_NEAR(code, k.u, 1);
        for (const uint8_t code : yuv.v) EXPECT_NEAR(code, k.v, 1);
    }
}

TEST(Yuv, ColourIsTheMeanOfItsPixels) {
    DisplayImage image{3, 1, {0, 0, 255, 255, 255, 255, 0, 255, 255, 0, 0, 255}};  // blue, yellow; red alone at the edge
    const YuvImage yuv = yuvOf(image);
    EXPECT_NEAR(yuv.u[0], 128, 1);
    EXPECT_NEAR(yuv.v[0], 128, 1);
    EXPECT_NEAR(yuv.u[1], 102, 1);
    EXPECT_NEAR(yuv.v[1], 240, 1);
}

TEST(Vp9Encoder, ADecoderSeesEveryPictureOfEverySize) {
    for (const auto& [width, height] : {std::pair(320u, 180u), {161u, 91u}, {16u, 16u}, {1u, 1u}, {7u, 50u}}) {
        const std::unique_ptr<VideoEncoder> encoder = makeVp9Encoder();
        Decoder decoder;
        std::vector<uint8_t> bytes;
        for (uint32_t time = 0; time < 6; time++) {
            const DisplayImage image = waves(width, height, time);
            encoder->encode(image, 80, bytes);
            EXPECT_EQ(encoder->key(), time == 0);
            EXPECT_LT(difference(decoder.decode(bytes), yuvOf(image)), 6.0) << width << " x " << height << ", picture " << time;
        }
    }
}

TEST(Vp9Encoder, PicturesThatBuildOnOthersAreSmaller) {
    const std::unique_ptr<VideoEncoder> encoder = makeVp9Encoder();
    std::vector<uint8_t> first, second, fine;
    encoder->encode(waves(320, 180, 0), 50, first);
    encoder->encode(waves(320, 180, 1), 50, second);
    EXPECT_LT(2 * second.size(), first.size());
    encoder->wantKey();
    encoder->encode(waves(320, 180, 2), 95, fine);
    EXPECT_GT(fine.size(), first.size()) << "the quality counts for each picture";
}

TEST(Vp9Encoder, AKeyPictureNeedsNoneBefore) {
    const std::unique_ptr<VideoEncoder> encoder = makeVp9Encoder();
    std::vector<uint8_t> bytes;
    for (uint32_t time = 0; time < 3; time++) encoder->encode(waves(160, 90, time), 80, bytes);
    Decoder late;
    EXPECT_EQ(late.decode(bytes).width, 0u) << "who joins cannot see this one";
    encoder->wantKey();
    for (uint32_t time = 3; time < 6; time++) {
        const DisplayImage image = waves(160, 90, time);
        encoder->encode(image, 80, bytes);
        EXPECT_EQ(encoder->key(), time == 3);
        EXPECT_LT(difference(late.decode(bytes), yuvOf(image)), 6.0) << time;
    }
}

TEST(Vp9Encoder, AnotherSizeBeginsWithAKeyPicture) {
    const std::unique_ptr<VideoEncoder> encoder = makeVp9Encoder();
    Decoder decoder;
    std::vector<uint8_t> bytes;
    uint32_t time = 0;
    for (const auto& [width, height] : {std::pair(160u, 90u), {320u, 180u}, {131u, 73u}}) {
        for (const bool key : {true, false}) {
            const DisplayImage image = waves(width, height, time++);
            encoder->encode(image, 80, bytes);
            EXPECT_EQ(encoder->key(), key) << width;
            EXPECT_LT(difference(decoder.decode(bytes), yuvOf(image)), 6.0) << width;
        }
    }
}

TEST(Vp9Encoder, RefusesWhatIsNoPictureAndGoesOn) {
    const std::unique_ptr<VideoEncoder> encoder = makeVp9Encoder();
    std::vector<uint8_t> bytes;
    EXPECT_THROW(encoder->encode({}, 80, bytes), std::runtime_error);
    EXPECT_THROW(encoder->encode({70'000, 1, std::vector<uint8_t>(280'000)}, 80, bytes), std::runtime_error);
    encoder->encode(waves(64, 48, 0), 80, bytes);
    EXPECT_TRUE(encoder->key());
}

TEST(VideoEncoder, WhatIsNotBuiltIsRefused) {
    EXPECT_TRUE(videoBuilt(VideoCodec::vp9));
    EXPECT_EQ(makeVideoEncoder(VideoCodec::vp9)->mimeType(), "video/vp9");
    EXPECT_EQ(videoFits(VideoCodec::h264, 1280, 720), videoBuilt(VideoCodec::h264));
    if (videoBuilt(VideoCodec::h264)) EXPECT_EQ(makeVideoEncoder(VideoCodec::h264)->mimeType(), "video/h264");
    else EXPECT_THROW(makeVideoEncoder(VideoCodec::h264), std::runtime_error);
}

TEST(Vp9Encoder, TheQuantizerFallsWithQuality) {
    for (uint32_t quality = 2; quality <= 100; quality++) EXPECT_LE(vp9Quantizer(quality), vp9Quantizer(quality - 1));
    EXPECT_LE(vp9Quantizer(0), 63u);
    EXPECT_EQ(vp9Quantizer(200), vp9Quantizer(100));
}

}  // namespace
}  // namespace heliograph::TEST_FILE

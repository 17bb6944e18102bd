#include "server/pace/codec_choice.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

/// Motion of so many seconds at 20 pictures a second; returns how often the codec changed.
int move(CodecChoice& choice, double seconds, double& now, uint32_t level, double lineDelay, double viewerDelay = 0.0) {
    int changes = 0;
    for (const double end = now + seconds; now < end; now += 0.05) changes += choice.seen(level, lineDelay, viewerDelay, now);
    return changes;
}

TEST(CodecChoice, AVideoIsForSlowLinesAlone) {
    CodecChoice choice;
    double now = 100.0;
    EXPECT_EQ(move(choice, 5.0, now, 0, 0.05), 0) << "pictures are as they were asked for";
    EXPECT_EQ(move(choice, 5.0, now, 3, 0.01, 0.2), 0) << "the viewer is slow: a video would be more work for it";
    EXPECT_EQ(move(choice, 5.0, now, 1, 0.05, 0.04), 0) << "both are slow now and then: a busy machine";
    EXPECT_FALSE(choice.video());
    EXPECT_EQ(move(choice, 5.0, now, 1, 0.07), 1);
    EXPECT_TRUE(choice.video());
    choice.reset();
    EXPECT_FALSE(choice.video());
}

TEST(CodecChoice, JpegIsTriedAgainAfterLongMotionWithoutAQueue) {
    CodecChoice choice;
    double now = 0.0;
    move(choice, 1.0, now, 1, 0.07);
    now += 3600.0;  // at rest nothing is learnt
    EXPECT_EQ(move(choice, 9.0, now, 0, 0.01), 0);
    EXPECT_EQ(move(choice, 0.1, now, 0, 0.03), 0) << "a queue: from the beginning";
    EXPECT_EQ(move(choice, 9.0, now, 0, 0.01), 0);
    EXPECT_EQ(move(choice, 2.0, now, 0, 0.01), 1);
    EXPECT_FALSE(choice.video());
}

TEST(CodecChoice, ALineThatStaysSlowIsTriedMoreAndMoreSeldom) {
    CodecChoice choice;
    double now = 0.0;
    int changes = 0;
    for (int second = 0; second < 1200; second++)
        changes += move(choice, 1.0, now, choice.video() ? 0 : 1, choice.video() ? 0.01 : 0.5);
    EXPECT_TRUE(choice.video());
    EXPECT_LE(changes, 15) << "JPEG after 10, 20, 40, 80, 160, 320, 320 seconds";
    EXPECT_GE(changes, 9);
}

TEST(CodecChoice, AVideoIsOneThatBothEndsKnow) {
    const Videos none, vp9{true, false}, h264{false, true}, both{true, true};
    const auto automatic = [](Videos made, Videos shown) { return videoFor(CodecSetting::automatic, made, shown); };
    EXPECT_EQ(automatic(both, both), CodecSetting::h264) << "the cheaper one";
    EXPECT_EQ(automatic(vp9, both), CodecSetting::vp9);
    EXPECT_EQ(automatic(both, vp9), CodecSetting::vp9);
    EXPECT_EQ(automatic(both, h264), CodecSetting::h264);
    EXPECT_EQ(automatic(vp9, h264), CodecSetting::jpeg);
    EXPECT_EQ(automatic(both, none), CodecSetting::jpeg);
    EXPECT_EQ(videoFor(CodecSetting::jpeg, both, both), CodecSetting::jpeg);
    EXPECT_EQ(videoFor(CodecSetting::vp9, both, both), CodecSetting::vp9);
    EXPECT_EQ(videoFor(CodecSetting::h264, both, both), CodecSetting::h264);
    EXPECT_EQ(videoFor(CodecSetting::h264, vp9, both), CodecSetting::jpeg) << "who asks for one is given no other";
    EXPECT_EQ(videoFor(CodecSetting::vp9, both, h264), CodecSetting::jpeg);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

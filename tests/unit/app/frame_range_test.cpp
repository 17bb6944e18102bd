#include "server/app/frame_range.h"

#include "server/app/picture_target.h"
#include "server/app/scene_options.h"
#include "server/base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

const CameraPath RING{
    "Ring", 2.0f, true, {{{4, 1, 0}, {0, 1, 0}}, {{0, 1, 4}, {0, 1, 0}}, {{-4, 1, 0}, {0, 1, 0}}, {{0, 1, -4}, {0, 1, 0}}}};

TEST(FrameRange, ReadsFirstAndLast) {
    EXPECT_EQ(parsedFrames("0:59"), (FrameRange{0, 59}));
    EXPECT_EQ(parsedFrames("7"), (FrameRange{7, 7}));
    EXPECT_EQ(parsedFrames("0:59").count(), 60u);
}

TEST(FrameRange, RefusesWhatIsNone) {
    for (const char* text : {"", ":", "5:", ":5", "6:5", "-1:5", "1:2:3", "a:b", "0:10000000", "1 :2"}) {
        SCOPED_TRACE(text);
        EXPECT_THAT([&] { parsedFrames(text); },
                    ThrowsMessage<InputError>(HasSubstr("--frames: '" + std::string(text) + "'; allowed: ")));
    }
}

TEST(FrameRange, AClosedPathEndsAFrameBeforeItBeginsAgain) {
    EXPECT_EQ(wholePath(RING, 24.0), (FrameRange{0, 47}));
    CameraPath open = RING;
    open.closed = false;
    EXPECT_EQ(wholePath(open, 24.0), (FrameRange{0, 48}));
    EXPECT_EQ(wholePath(RING, 0.01), (FrameRange{0, 0}));
}

TEST(FrameRange, FramesStandWhereThePathIsAtTheirTime) {
    const Camera quarter = cameraAtFrame(RING, 12, 24.0, 50.0f);
    EXPECT_NEAR(quarter.position.x, 0.0f, 1e-5f);
    EXPECT_NEAR(quarter.position.z, 4.0f, 1e-5f);
    EXPECT_EQ(quarter.fieldOfView, 50.0f);
    EXPECT_EQ(cameraAtFrame(RING, -1, 24.0, 50.0f), cameraAtFrame(RING, 47, 24.0, 50.0f));
}

TEST(FrameRange, TimeLeftIsThatOfTheFramesSoFar) {
    EXPECT_EQ(secondsLeft(0, 10, 3.0), std::nullopt);
    EXPECT_DOUBLE_EQ(*secondsLeft(2, 10, 3.0), 12.0);
    EXPECT_DOUBLE_EQ(*secondsLeft(10, 10, 3.0), 0.0);
}

TEST(FrameRange, DurationsAreWordsForPeople) {
    EXPECT_EQ(durationText(7.6), "8 s");
    EXPECT_EQ(durationText(200.0), "3 min 20 s");
    EXPECT_EQ(durationText(7500.0), "2 h 5 min");
}

TEST(FramePattern, HasOnePlaceForTheNumber) {
    EXPECT_EQ(framePattern("a.%04d.exr")->name(7), "a.0007.exr");
    EXPECT_EQ(framePattern("a%d.png")->name(12), "a12.png");
    EXPECT_EQ(framePattern("a.%02d.png")->name(12345), "a.12345.png");
    for (const char* text :
         {"a.png", "a%.png", "a%s.png", "a%4d.png", "a%d%d.png", "a%00d.png", "a%0d.png", "a%010d.png", "%", "a%04d%"})
        EXPECT_EQ(framePattern(text), std::nullopt) << text;
}

TEST(TypedCamera, IsAPlaceATargetAndDegrees) {
    const Camera camera = *typedCamera("0,2,8:0,2,0:50");
    EXPECT_EQ(camera.position, vec3(0, 2, 8));
    EXPECT_EQ(camera.forward, vec3(0, 0, -1));
    EXPECT_EQ(camera.up, vec3(0, 1, 0));
    EXPECT_EQ(camera.fieldOfView, 50.0f);
    EXPECT_EQ(typedCamera("0,2,8:0,2,0")->fieldOfView, 60.0f);
    EXPECT_EQ(typedCamera("-1e1,.5,8:0,-2,0")->position, vec3(-10, 0.5f, 8));
}

TEST(TypedCamera, LookingDownHasNorthUp) {
    const Camera camera = *typedCamera("0,9,0:0,0,0");
    EXPECT_EQ(camera.forward, vec3(0, -1, 0));
    EXPECT_NEAR(camera.up.z, -1.0f, 1e-6f);
}

TEST(TypedCamera, NamesAreNoCameras) {
    for (const char* name : {"Front", "a:b", "1,2:3", "1,2,3", "1,2,3,4:5,6,7"}) EXPECT_FALSE(typedCamera(name)) << name;
}

TEST(TypedCamera, SaysWhatIsWrong) {
    for (const char* text : {"0,0,0:1,1", "0,0,0:1,1,1:", "0,0,0:1,1,1:50:2", "0,0,0:1,1,1:x", "0,0,0:1,nan,1"})
        EXPECT_THAT([&] { typedCamera(text); }, ThrowsMessage<InputError>(HasSubstr("allowed: x,y,z:tx,ty,tz"))) << text;
    EXPECT_THAT([] { typedCamera("1,1,1:1,1,1"); }, ThrowsMessage<InputError>(HasSubstr("a target at another place")));
    EXPECT_THAT([] { typedCamera("0,0,0:1,1,1:200"); }, ThrowsMessage<InputError>(HasSubstr("0.01 to 179 degrees")));
}

}  // namespace
}  // namespace heliograph::TEST_FILE

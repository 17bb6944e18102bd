#include "server/request/view_request.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

ViewRequest request() {
    ViewRequest r;
    r.resolution = {640, 480};
    r.inputId = 5;
    return r;
}

ViewRequest moved() {
    ViewRequest r = request();
    r.camera.position.x += 1.0f;
    return r;
}

TEST(ViewRequest, FilmSizeFollowsRenderScaleAndIsNeverEmpty) {
    ViewRequest r = request();
    EXPECT_EQ(filmSize(r), uvec2(640, 480));
    r.settings.renderScale = 0.5f;
    EXPECT_EQ(filmSize(r), uvec2(320, 240));
    r.resolution = {1, 3};
    r.settings.renderScale = 0.125f;
    EXPECT_EQ(filmSize(r), uvec2(1, 1));
}

TEST(ViewRequest, WhatActsAfterTheFilmKeepsIt) {
    ViewRequest r = request();
    r.inputId = 9;
    r.moving = true;
    r.settings.samples = 7;
    r.settings.exposure = 2.0f;
    r.settings.toneCurve = 1;
    r.settings.jpegQuality = 20;
    EXPECT_TRUE(sameFilm(request(), r));
    EXPECT_FALSE(samePicture(request(), r));
}

TEST(ViewRequest, WhatChangesSamplesNeedsANewFilm) {
    EXPECT_FALSE(sameFilm(request(), moved()));
    ViewRequest r = request();
    r.settings.aoPower = 2.0f;
    EXPECT_FALSE(sameFilm(request(), r));
    r = request();
    r.resolution.x++;
    EXPECT_FALSE(sameFilm(request(), r));
    r = request();
    r.settings.renderScale = 0.5f;
    EXPECT_FALSE(sameFilm(request(), r));
}

TEST(ViewRequest, MovingOrTargetAloneIsTheSamePicture) {
    ViewRequest r = request();
    r.moving = true;
    r.settings.samples = 1000;
    EXPECT_TRUE(samePicture(request(), r));
}

TEST(CancelsPass, FirstPassIsFinishedWhileTheCameraMoves) {
    EXPECT_FALSE(cancelsPass(request(), 0, false, moved()));
    EXPECT_TRUE(cancelsPass(request(), 1, false, moved()));
    EXPECT_TRUE(cancelsPass(request(), 63, true, moved()));
}

TEST(CancelsPass, ChangedSettingsCancelTheFirstPassButNotTwiceInARow) {
    ViewRequest changed = request();
    changed.settings.ambientOcclusion = true;
    EXPECT_TRUE(cancelsPass(request(), 0, false, changed));
    EXPECT_FALSE(cancelsPass(request(), 0, true, changed));
    EXPECT_TRUE(cancelsPass(request(), 1, true, changed));
}

TEST(CancelsPass, WhatTheFilmServesTooCancelsNothing) {
    ViewRequest brighter = request();
    brighter.settings.exposure = 1.0f;
    brighter.inputId++;
    EXPECT_FALSE(cancelsPass(request(), 5, false, brighter));
}

TEST(FrameDue, FirstSampleAndNewInputAndLastSampleAlways) {
    EXPECT_FALSE(frameDue({.samples = 0}));
    EXPECT_TRUE(frameDue({.samples = 1, .targetSamples = 64}));
    EXPECT_FALSE(frameDue({.samples = 1, .targetSamples = 64, .deliveredSamples = 1, .secondsSince = 100.0}));
    EXPECT_TRUE(frameDue({.samples = 1, .targetSamples = 64, .deliveredSamples = 1, .outdated = true}));
    EXPECT_TRUE(frameDue({.samples = 64, .targetSamples = 64, .deliveredSamples = 63}));
    EXPECT_FALSE(frameDue({.samples = 64, .targetSamples = 64, .deliveredSamples = 64, .finalDelivered = true}));
    // The target was lowered to what has been delivered already: still to be told.
    EXPECT_TRUE(frameDue({.samples = 40, .targetSamples = 32, .deliveredSamples = 40}));
}

TEST(FrameDue, BetweenThemWhenClearlyBetterAtMostTenTimesASecond) {
    EXPECT_FALSE(frameDue({.samples = 8, .targetSamples = 64, .deliveredSamples = 4, .secondsSince = 0.05}));
    EXPECT_TRUE(frameDue({.samples = 8, .targetSamples = 64, .deliveredSamples = 4, .secondsSince = 0.11}));
    EXPECT_FALSE(frameDue({.samples = 45, .targetSamples = 64, .deliveredSamples = 40, .secondsSince = 0.2}));
    EXPECT_TRUE(frameDue({.samples = 45, .targetSamples = 64, .deliveredSamples = 40, .secondsSince = 0.41}));
}

TEST(TilesPerTurn, FewWhileOthersWaitButEnoughForAllWorkers) {
    EXPECT_EQ(tilesPerTurn(0.001, 2, true), 10u);
    EXPECT_EQ(tilesPerTurn(0.001, 2, false), 150u);
    EXPECT_EQ(tilesPerTurn(1.0, 16, true), 32u);
    EXPECT_EQ(tilesPerTurn(1.0, 16, false), 64u);
    EXPECT_EQ(tilesPerTurn(0.0, 1, true), 2u);
    EXPECT_GT(tilesPerTurn(1e-12, 1, false), 1000u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

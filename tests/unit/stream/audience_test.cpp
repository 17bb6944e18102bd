#include "server/stream/audience.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

FinishedFrame frameWith(uint32_t generation, uint32_t samples) {
    FinishedFrame frame;
    frame.generation = generation;
    frame.samples = samples;
    return frame;
}

TEST(Audience, AFrameIsWantedUntilItWasGiven) {
    const Shown first = shownBy(frameWith(1, 1));
    EXPECT_TRUE(wants({}, first, 0)) << "a newcomer has seen nothing";
    const Given given{first, 5};
    EXPECT_FALSE(wants(given, first, 5));
    EXPECT_TRUE(wants(given, first, 6)) << "the same picture answers a newer input";
    EXPECT_TRUE(wants(given, shownBy(frameWith(1, 2)), 5)) << "more samples";
    EXPECT_TRUE(wants(given, shownBy(frameWith(2, 1)), 5)) << "another film";
    FinishedFrame last = frameWith(1, 1);
    last.final = true;
    EXPECT_TRUE(wants(given, shownBy(last), 5)) << "now it is known that no more will come";
}

TEST(Audience, OnlyWhatCanBeSeenMakesAnotherPicture) {
    FinishedFrame frame = frameWith(1, 1);
    const Given given{shownBy(frame), 5};
    frame.view.inputId = 77;  // of who drives
    frame.view.settings.jpegQuality = 20;
    EXPECT_FALSE(wants(given, shownBy(frame), 5));
    frame.view.settings.exposure = 1.0f;
    EXPECT_TRUE(wants(given, shownBy(frame), 5));
}

TEST(Audience, InputIdsAreThoseOfTheViewerItself) {
    ViewRequest view;
    view.viewer = 3;
    view.inputId = 50;
    EXPECT_EQ(inputShown(view, 3, 7), 50u) << "it drives";
    EXPECT_EQ(inputShown(view, 4, 7), 7u) << "it watches: the ids of others mean nothing to it";
    EXPECT_EQ(inputShown(view, 3, 60), 60u) << "never back";
}

TEST(Audience, OneWithRoomIsEnough) {
    using enum Readiness;
    auto of = [](std::vector<Readiness> viewers, size_t films = 0) { return together(viewers, films); };
    EXPECT_EQ(of({}), stalled) << "nobody looks";
    for (Readiness one : {ready, busy, noCredit, stalled}) EXPECT_EQ(of({one}), one);
    EXPECT_EQ(of({stalled, ready, noCredit}), ready);
    EXPECT_EQ(of({stalled, noCredit}), noCredit);
    EXPECT_EQ(of({noCredit, busy}), busy);
    EXPECT_EQ(of({ready, busy}, FILMS_HANDED_OUT - 1), ready);
    EXPECT_EQ(of({ready, busy}, FILMS_HANDED_OUT), busy) << "films are memory";
    EXPECT_EQ(of({stalled}, FILMS_HANDED_OUT), stalled);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "server/request/loop_rules.h"

#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

constexpr Readiness EVERY[] = {Readiness::ready, Readiness::busy, Readiness::noCredit, Readiness::stalled};

/// A film of the newest request with so many samples of 16, the last of them delivered just now.
LoopState at(uint32_t samples) {
    LoopState state;
    state.hasWork = state.filmFits = true;
    state.delivery = {samples, 16, samples, false, samples >= 16, 0.0};
    return state;
}

/// The same, but the viewer wants something else by now.
LoopState outdated(uint32_t samples, uint32_t delivered) {
    LoopState state = at(samples);
    state.filmFits = false;
    state.delivery.deliveredSamples = delivered;
    return state;
}

TEST(LoopRules, RestsWithoutWorkWhateverElse) {
    for (Readiness readiness : EVERY) {
        LoopState state = outdated(1, 0);
        state.hasWork = false;
        state.readiness = readiness;
        state.picture = PictureState::finished;
        EXPECT_EQ(next(state), LoopAction::rest);
    }
}

TEST(LoopRules, BeginsWithAFilm) { EXPECT_EQ(next(outdated(0, 0)), LoopAction::startFilm); }

TEST(LoopRules, AccumulatesUpToTheTargetAndRests) {
    EXPECT_EQ(next(at(0)), LoopAction::renderFilm);
    EXPECT_EQ(next(at(15)), LoopAction::renderFilm);
    EXPECT_EQ(next(at(16)), LoopAction::rest);
    EXPECT_EQ(next(at(40)), LoopAction::rest) << "the target was lowered";
}

TEST(LoopRules, DeliversWhatIsDueOnlyToWhoIsReady) {
    LoopState state = at(1);
    state.delivery.deliveredSamples = 0;
    EXPECT_EQ(next(state), LoopAction::deliverFilm);
    for (Readiness readiness : {Readiness::busy, Readiness::noCredit, Readiness::stalled}) {
        state.readiness = readiness;
        EXPECT_EQ(next(state), LoopAction::renderFilm) << "time is used meanwhile";
    }
}

TEST(LoopRules, ANewerInputOfTheSameViewNeedsNoNewFilm) {
    LoopState state = at(16);
    state.delivery.outdated = true;
    EXPECT_EQ(next(state), LoopAction::deliverFilm);
}

TEST(LoopRules, AFirstPassIsSeenBeforeTheFilmIsUsedAgain) {
    EXPECT_EQ(next(outdated(1, 0)), LoopAction::deliverFilm);
    EXPECT_EQ(next(outdated(1, 1)), LoopAction::startFilm);
    EXPECT_EQ(next(outdated(7, 5)), LoopAction::startFilm) << "the viewer has seen this view";
}

TEST(LoopRules, WithoutCreditANewerPictureReplacesTheWaitingOneUnlessOthersNeedTheDevice) {
    LoopState state = outdated(1, 0);
    state.readiness = Readiness::noCredit;
    state.alone = true;
    EXPECT_EQ(next(state), LoopAction::startFilm);
    state.alone = false;
    EXPECT_EQ(next(state), LoopAction::rest);
    for (Readiness readiness : {Readiness::busy, Readiness::stalled}) {
        state.readiness = readiness;
        state.alone = true;
        EXPECT_EQ(next(state), LoopAction::rest) << "it may come soon, or nobody looks";
    }
}

TEST(LoopRules, PassesOfPictureAndFilmAlternate) {
    LoopState state = at(4);
    state.picture = PictureState::unfinished;
    EXPECT_EQ(next(state), LoopAction::renderFilm);
    state.pictureTurn = true;
    EXPECT_EQ(next(state), LoopAction::renderPicture);
    state = at(16);
    state.picture = PictureState::unfinished;
    EXPECT_EQ(next(state), LoopAction::renderPicture) << "the film needs nothing more";
}

TEST(LoopRules, APictureHasItsTurnsWhileTheCameraMoves) {
    LoopState state = outdated(1, 1);
    state.picture = PictureState::unfinished;
    EXPECT_EQ(next(state), LoopAction::startFilm);
    state.pictureTurn = true;
    EXPECT_EQ(next(state), LoopAction::renderPicture);
}

TEST(LoopRules, APictureNeedsNoCreditButAFreeEncoder) {
    for (Readiness readiness : EVERY) {
        LoopState state = at(16);
        state.picture = PictureState::finished;
        state.readiness = readiness;
        EXPECT_EQ(next(state), readiness == Readiness::busy ? LoopAction::rest : LoopAction::deliverPicture);
    }
}

// Whatever the state, something due is never forgotten: the loop rests only where nothing can be done.
TEST(LoopRules, RestsOnlyWithNothingLeftOrSomebodyToWaitFor) {
    for (uint32_t samples : {0u, 1u, 8u, 16u}) {
        for (uint32_t delivered : {0u, 1u, 8u, 16u}) {
            for (Readiness readiness : EVERY) {
                for (int bits = 0; bits < 8; bits++) {
                    LoopState state = at(samples);
                    state.delivery.deliveredSamples = std::min(delivered, samples);
                    state.delivery.finalDelivered = state.delivery.deliveredSamples == 16;
                    state.readiness = readiness;
                    state.filmFits = (bits & 1) != 0;
                    state.alone = (bits & 2) != 0;
                    state.pictureTurn = (bits & 4) != 0;
                    for (PictureState picture : {PictureState::none, PictureState::unfinished, PictureState::finished}) {
                        state.picture = picture;
                        if (next(state) != LoopAction::rest) continue;
                        const bool done = state.filmFits && samples == 16 && delivered == 16 && picture == PictureState::none;
                        EXPECT_TRUE(done || readiness != Readiness::ready);
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

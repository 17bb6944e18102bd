// The measurement of what accuracy costs, as a viewer asks for it and is told of it.

#include "tests/unit/stream/stream_fakes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;
using testing::HasSubstr;

constexpr double LONG = 600.0;  // seconds: nothing that a test waits for

json ask(double seconds) { return {{"type", "accuracy"}, {"seconds", seconds}}; }

/// What was told of accuracy so far.
std::vector<json> told(Line& line) {
    std::lock_guard lock(line.socket->mutex);
    std::vector<json> all;
    for (const json& text : line.socket->texts)
        if (text["type"] == "accuracy") all.push_back(text);
    return all;
}

std::string state(Line& line) {
    const json last = line.socket->last("accuracy");
    return last.is_null() ? "" : last["state"];
}

/// Until a frame of the measurement has been made, or at least begun.
void untilItRuns(Line& line) {
    ASSERT_TRUE(line.socket->until([&] {
        return !line.socket->texts.empty() && line.socket->texts.back()["type"] == "accuracy" &&
               line.socket->texts.back().value("share", 0.0) > 0.0;
    }));
}

struct AccuracyOfAView : testing::Test {
    void SetUp() override {
        line.session->begin();
        line.size();
        ASSERT_TRUE(line.socket->untilFrame(1));
    }
    Line line;
};

TEST_F(AccuracyOfAView, ComesOnDemandInTheEnd) {
    line.say({{"type", "settings"}, {"inputId", 2}, {"values", {{"samples", 4}}}});
    line.say(ask(5.0));
    EXPECT_EQ(told(line).front(), (json{{"type", "accuracy"}, {"state", "measuring"}, {"share", 0.0}, {"what", ""}}));
    ASSERT_TRUE(line.socket->until(
        [&] { return line.socket->texts.back()["type"] == "accuracy" && line.socket->texts.back()["state"] == "ready"; }));
    const json ready = line.socket->last("accuracy");
    EXPECT_EQ(ready["scene"], "first");
    EXPECT_EQ(ready["device"], "embree");
    EXPECT_EQ(ready["size"], (json{64, 48}));
    EXPECT_EQ(ready["scale"], 1.0);
    EXPECT_EQ(ready["samples"], 4);
    EXPECT_GT(ready["seconds"], 0.0);
    EXPECT_EQ(ready["referenceError"], 0.0) << "all is grey";
    EXPECT_EQ(ready["pictures"]["exact"].get<std::string>().substr(0, 11), "iVBORw0KGgo") << "a PNG";
    size_t given = 0, front = 0, coding = 0;
    for (const json& row : ready["rows"]) {
        given += row["given"] == true;
        front += row["front"] == true;
        coding += row["coding"] == true;
        EXPECT_EQ(row["rmse"].is_null(), row["coding"] == true);
        EXPECT_TRUE(row["set"].is_object());
    }
    EXPECT_GT(given, 0u);
    EXPECT_GT(front, 0u);
    EXPECT_GT(coding, 0u);
}

TEST_F(AccuracyOfAView, NeedsSomethingToSeeAndTimeWithinBounds) {
    Line other;
    other.session->begin();
    other.say(ask(30.0));
    EXPECT_EQ(other.socket->last("error")["about"], "accuracy") << "no resolution yet";
    line.say(ask(4.0));
    EXPECT_EQ(line.socket->last("error")["about"], "accuracy");
    EXPECT_THAT(line.socket->last("error")["message"], HasSubstr("accuracy.seconds: 4.0; allowed: 0, or 5 to 600"));
    EXPECT_TRUE(told(line).empty());
}

TEST_F(AccuracyOfAView, IsGivenUpByWhoAskedForIt) {
    line.say(ask(0.0));
    EXPECT_TRUE(told(line).empty()) << "nothing runs";
    line.say(ask(LONG));
    untilItRuns(line);
    line.say(ask(0.0));
    EXPECT_EQ(told(line).back(), (json{{"type", "accuracy"}, {"state", "given-up"}}));
    const size_t before = told(line).size();
    line.say(ask(0.0));
    EXPECT_EQ(told(line).size(), before) << "it was told once";
}

TEST_F(AccuracyOfAView, ANewerOneReplacesIt) {
    line.say(ask(LONG));
    untilItRuns(line);
    line.say(ask(LONG));
    const std::vector<json> all = told(line);
    ASSERT_GE(all.size(), 3u);
    const auto end = std::ranges::find(all, "given-up", [](const json& text) { return text["state"].get<std::string>(); });
    ASSERT_LT(end + 1, all.end());
    EXPECT_EQ((end + 1)->at("state"), "measuring");
    EXPECT_EQ((end + 1)->at("share"), 0.0);
}

TEST_F(AccuracyOfAView, AnotherSceneEndsItAndAnotherCameraDoesNot) {
    line.say(ask(LONG));
    line.look(2);
    line.say({{"type", "settings"}, {"inputId", 3}, {"values", {{"shadows", false}}}});
    untilItRuns(line);
    EXPECT_EQ(state(line), "measuring");
    line.say({{"type", "scene"}, {"name", "second"}});
    EXPECT_EQ(state(line), "given-up");
}

TEST_F(AccuracyOfAView, AFailureIsTold) {
    {
        Turns::Account account;  // so that it has not begun yet
        auto turn = line.host.turns_.take(account, {});
        line.say(ask(LONG));
        line.host.device->poor = true;
    }
    ASSERT_TRUE(line.socket->until(
        [&] { return line.socket->texts.back()["type"] == "accuracy" && line.socket->texts.back()["state"] == "failed"; }));
    EXPECT_NE(line.socket->last("accuracy")["what"], "");
    line.host.device->poor = false;
}

TEST_F(AccuracyOfAView, OthersAreAnsweredMeanwhile) {
    Line neighbour(line.host_, 8);
    neighbour.size();
    ASSERT_TRUE(neighbour.socket->untilFrame(1));
    line.say(ask(LONG));
    untilItRuns(line);
    for (uint32_t input = 2; input < 12; input++) {
        uint32_t frame = 0;
        ASSERT_TRUE(neighbour.socket->until([&] {
            frame = neighbour.socket->headers.back().frameId;
            return neighbour.socket->headers.back().inputId == input - 1;
        }));
        neighbour.ack(frame);
        neighbour.look(input);
    }
    EXPECT_TRUE(neighbour.socket->until([&] { return neighbour.socket->headers.back().inputId == 11; }));
    EXPECT_EQ(state(line), "measuring");
    EXPECT_EQ(state(neighbour), "") << "only who asked is told";
    line.say(ask(0.0));
    EXPECT_EQ(state(line), "given-up");
}

TEST_F(AccuracyOfAView, HandingTheViewOverEndsIt) {
    Line other(line.host_, 8);
    other.say({{"type", "watch"}, {"view", line.socket->last("hello")["view"]}, {"inputId", 2}});
    line.say(ask(LONG));
    line.say({{"type", "drive"}, {"inputId", 3}, {"viewer", 8}});
    EXPECT_EQ(state(line), "given-up");
    EXPECT_EQ(state(other), "");
    other.say(ask(LONG));
    EXPECT_EQ(state(other), "measuring") << "who drives now may";
}

}  // namespace
}  // namespace heliograph::TEST_FILE

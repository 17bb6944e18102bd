// A machine or container that gives no more threads, while those of a view and of a viewer rest.

#include "tests/support/no_threads.h"
#include "tests/support/until.h"
#include "tests/unit/stream/stream_fakes.h"
#include <gtest/gtest.h>

namespace heliograph::TEST_FILE {
namespace {

using namespace test;

struct ThreadsShort : testing::Test {
    /// Looks, acknowledges all it is given and has its answer.
    bool answered(uint32_t inputId) {
        const bool came =
            line.socket->until([&] { return !line.socket->headers.empty() && line.socket->headers.back().inputId == inputId; });
        line.ack(static_cast<uint32_t>(line.socket->headers.size()));
        return came;
    }
    void tick() { line.session->tick(Session::Clock::now()); }
    size_t told() {
        std::lock_guard lock(line.socket->mutex);
        return static_cast<size_t>(
            std::ranges::count_if(line.socket->texts, [](const json& text) { return text["type"] == "error"; }));
    }

    Line line;
};

TEST_F(ThreadsShort, WhatAViewerAskedIsDrawnAsSoonAsThereIsAThread) {
    line.session->begin();
    line.size();
    ASSERT_TRUE(answered(1));
    ASSERT_TRUE(until([&] { return line.session->resting(); })) << "at rest there are none";
    {
        NoThreads none;
        line.look(2);
        tick();
        tick();
        EXPECT_EQ(told(), 1u) << line.socket->last("error");
        EXPECT_EQ(line.socket->headers.size(), 1u);
    }
    tick();
    EXPECT_TRUE(answered(2));
    EXPECT_EQ(told(), 1u);
}

TEST_F(ThreadsShort, AFrameThatCannotBeEncodedYetComesAsSoonAsThereIsAThread) {
    line.session->begin();
    line.size();
    ASSERT_TRUE(answered(1));
    ASSERT_TRUE(until([&] { return line.session->resting(); }));
    line.host.device->hold(true);
    line.look(2);  // wakes the view's thread alone
    ASSERT_TRUE(until([&] { return !line.session->resting(); }));
    {
        NoThreads none;
        line.host.device->hold(false);
        ASSERT_TRUE(until([&] {
            tick();
            return told() == 1;
        }));
        EXPECT_EQ(line.socket->headers.size(), 1u);
    }
    tick();
    EXPECT_TRUE(answered(2));
    line.look(3);
    EXPECT_TRUE(answered(3));
}

}  // namespace
}  // namespace heliograph::TEST_FILE

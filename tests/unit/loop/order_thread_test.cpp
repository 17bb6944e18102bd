#include "server/loop/order_thread.h"

#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

TEST(OrderThread, DoesOneOrderAfterTheOther) {
    std::atomic<int> done = 0;
    OrderThread<int> thread([&](int order, std::stop_token) { done = order; });
    for (int order = 1; order <= 3; order++) {
        thread.order(order);
        EXPECT_TRUE(test::until([&] { return done == order; }));
    }
}

TEST(OrderThread, ANewerOrderEndsTheOneUnderWayAndReplacesThoseThatWait) {
    std::mutex mutex;
    std::vector<int> begun;
    std::atomic<bool> first = false, last = false;
    OrderThread<int> thread([&](int order, std::stop_token dropped) {
        {
            std::lock_guard lock(mutex);
            begun.push_back(order);
        }
        if (order == 1) {
            first = true;
            EXPECT_TRUE(test::until([&] { return dropped.stop_requested() && last; }));
        } else {
            EXPECT_FALSE(dropped.stop_requested());
            first = false;
        }
    });
    thread.order(1);
    EXPECT_TRUE(test::until([&] { return first.load(); }));
    thread.order(2);
    thread.order(3);
    last = true;
    EXPECT_TRUE(test::until([&] { return !first; }));
    std::lock_guard lock(mutex);
    EXPECT_EQ(begun, (std::vector<int>{1, 3}));
}

TEST(OrderThread, WhatIsDroppedIsToldSoAndItsEndIsWaitedFor) {
    std::atomic<bool> begun = false, ended = false;
    {
        OrderThread<int> thread([&](int, std::stop_token dropped) {
            begun = true;
            EXPECT_TRUE(test::until([&] { return dropped.stop_requested(); }));
            ended = true;
        });
        thread.drop();  // nothing
        thread.order(1);
        EXPECT_TRUE(test::until([&] { return begun.load(); }));
    }
    EXPECT_TRUE(ended);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "server/base/resting_thread.h"

#include "tests/support/no_threads.h"
#include "tests/support/until.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <list>

namespace heliograph::TEST_FILE {
namespace {

TEST(RestingThread, IsNotThereBeforeItsFirstCallAndLeavesWhenNobodyCalls) {
    std::atomic<int> turns{0};
    RestingThread thread([&] { return ++turns < 0; }, 0.01);
    EXPECT_FALSE(thread.awake());
    thread.call();
    EXPECT_TRUE(test::until([&] { return turns == 1 && !thread.awake(); }));
    thread.call();
    EXPECT_TRUE(test::until([&] { return turns == 2 && !thread.awake(); }));
}

TEST(RestingThread, WorksAsLongAsThereIsSomethingToDo) {
    std::atomic<int> left{100};
    RestingThread thread([&] { return left > 0 && --left >= 0; });
    thread.call();
    EXPECT_TRUE(test::until([&] { return left == 0; }));
}

TEST(RestingThread, ACallDuringATurnIsAnsweredByAnotherTurn) {
    std::atomic<int> turns{0};
    std::atomic<bool> held{true};
    RestingThread thread([&] {
        if (++turns == 1) {
            EXPECT_TRUE(test::until([&] { return !held; }));
        }
        return false;
    });
    thread.call();
    EXPECT_TRUE(test::until([&] { return turns == 1; }));
    thread.call();
    held = false;
    EXPECT_TRUE(test::until([&] { return turns == 2; }));
}

TEST(RestingThread, ManyCallersAndLeavesLoseNoCall) {
    std::atomic<int> asked{0}, done{0};
    RestingThread thread(
        [&] {
            done = asked.load();
            return false;
        },
        0);
    for (int i = 1; i <= 2000; i++) {
        asked = i;
        thread.call();
        if (i % 20 == 0) {
            ASSERT_TRUE(test::until([&] { return done == i; })) << i;
        }
    }
    EXPECT_TRUE(test::until([&] { return done == 2000; }));
}

TEST(RestingThread, WhatGotNoThreadIsDoneWhenThereIsOne) {
    std::atomic<int> turns{0};
    RestingThread thread([&] { return ++turns < 0; });
    EXPECT_TRUE(thread.retry()) << "nothing was called for";
    {
        test::NoThreads none;
        EXPECT_FALSE(thread.call());
        EXPECT_FALSE(thread.retry());
        EXPECT_FALSE(thread.awake());
    }
    EXPECT_EQ(turns, 0);
    EXPECT_TRUE(thread.retry());
    EXPECT_TRUE(test::until([&] { return turns == 1; }));
}

TEST(RestingThread, EndsWithoutTheThreadItNeverGot) {
    std::atomic<int> turns{0};
    RestingThread thread([&] { return ++turns < 0; });
    test::NoThreads none;
    EXPECT_FALSE(thread.call());
    thread.finish();
    EXPECT_EQ(turns, 0);
}

TEST(RestingThread, LetsGoOfWhatItNeededOnceItLeaves) {
    std::atomic<int> turns{0}, left{0};
    RestingThread thread([&] { return ++turns < 0; }, 0.01, [&] { left++; });
    thread.call();
    EXPECT_TRUE(test::until([&] { return turns == 1 && !thread.awake(); }));
    EXPECT_EQ(left, 1);
    thread.call();
    EXPECT_TRUE(test::until([&] { return turns == 2 && !thread.awake(); }));
    EXPECT_EQ(left, 2);
}

TEST(RestingThread, ACallWhileItLeavesIsAnswered) {
    std::atomic<int> turns{0};
    std::atomic<bool> leaves{false}, held{true};
    RestingThread thread([&] { return ++turns < 0; }, 0.0,
                         [&] {
                             leaves = true;
                             EXPECT_TRUE(test::until([&] { return !held; }));
                         });
    thread.call();
    EXPECT_TRUE(test::until([&] { return leaves.load(); }));
    thread.call();
    held = false;
    EXPECT_TRUE(test::until([&] { return turns == 2; }));
}

/// Bytes of addresses that the process has taken.
size_t addresses() {
    size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<size_t>(sysconf(_SC_PAGESIZE));
}

TEST(RestingThread, KeepsNoStackOnceItHasLeft) {
    constexpr size_t COUNT = 128,
                     KEPT = size_t{192} << 20;  // what the system keeps of those that have ended, and for their memory
    pthread_attr_t attributes;
    ASSERT_EQ(pthread_getattr_default_np(&attributes), 0);
    size_t stack = 0;
    ASSERT_EQ(pthread_attr_getstacksize(&attributes, &stack), 0);
    pthread_attr_destroy(&attributes);
    std::list<RestingThread> threads;
    const size_t before = addresses();
    for (size_t i = 0; i < COUNT; i++) {
        threads.emplace_back([] { return false; }, 0.0);
        threads.back().call();
        ASSERT_TRUE(test::until([&] { return !threads.back().awake(); }));
    }
    EXPECT_LT(addresses(), before + std::max(COUNT / 2 * stack, KEPT));
}

TEST(RestingThread, EndsAfterWhatIsLeftToDo) {
    std::atomic<int> left{5};
    RestingThread thread([&] { return left > 0 && --left >= 0; });
    thread.call();
    thread.finish();
    EXPECT_EQ(left, 0);
    thread.call();
    EXPECT_FALSE(thread.awake());
}

}  // namespace
}  // namespace heliograph::TEST_FILE

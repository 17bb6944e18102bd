#include "server/base/crew.h"

#include "tests/support/until.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>

namespace heliograph::TEST_FILE {
namespace {

TEST(Crew, SeveralThreadsHelpAndAllHaveEndedWhenItReturns) {
    Crew crew;
    std::atomic<int> inside{0}, most{0};
    crew.run(3, [&] {
        const int now = ++inside;
        for (int before = most; before < now && !most.compare_exchange_weak(before, now);) {}
        EXPECT_TRUE(test::until([&] { return most == 4; }));
        inside--;
    });
    EXPECT_EQ(inside, 0);
    EXPECT_EQ(most, 4);
}

TEST(Crew, WhoComesTooLateIsNotWaitedFor) {
    Crew crew;
    std::atomic<bool> held{true};
    std::atomic<int> inside{0};
    std::jthread other([&] {  // has the only helper
        crew.run(1, [&] {
            inside++;
            EXPECT_TRUE(test::until([&] { return !held; }));
        });
    });
    ASSERT_TRUE(test::until([&] { return inside == 2; }));
    int calls = 0;
    crew.run(1, [&] { calls++; });
    EXPECT_EQ(calls, 1);
    held = false;
}

TEST(Crew, ThrowsWhatAnyOfThemThrew) {
    Crew crew;
    const auto caller = std::this_thread::get_id();
    EXPECT_THROW(crew.run(1, [] { throw std::runtime_error("both"); }), std::runtime_error);
    std::atomic<bool> helped{false};
    EXPECT_THROW(crew.run(1,
                          [&] {
                              if (std::this_thread::get_id() == caller) return void(test::until([&] { return helped.load(); }));
                              helped = true;
                              throw std::runtime_error("the helper");
                          }),
                 std::runtime_error);
    int calls = 0;
    crew.run(0, [&] { calls++; });
    EXPECT_EQ(calls, 1) << "it goes on";
}

TEST(Crew, ManyCallersShareIt) {
    Crew crew;
    std::vector<std::jthread> callers;
    for (int caller = 0; caller < 4; caller++) {
        callers.emplace_back([&] {
            for (int round = 0; round < 500; round++) {
                std::atomic<int> next{0}, sum{0};
                crew.run(2, [&] {
                    for (int i; (i = next++) < 20;) sum += i;
                });
                EXPECT_EQ(sum, 190);
            }
        });
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

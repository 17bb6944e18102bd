#include "server/base/made_once.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

TEST(MadeOnce, OneThreadMakesItForAll) {
    MadeOnce<int, std::string> once;
    std::atomic<int> made{0}, waiting{0};
    std::atomic<bool> open{false};
    std::vector<std::shared_ptr<const std::string>> got(8);
    {
        std::vector<std::jthread> threads;
        for (auto& mine : got) {
            threads.emplace_back([&] {
                waiting++;
                mine = once.get(7, [&] {
                    made++;
                    open.wait(false);
                    return std::string("seven");
                });
            });
        }
        while (waiting < 8) std::this_thread::yield();
        open = true;
        open.notify_all();
    }
    EXPECT_EQ(made, 1);
    for (const auto& mine : got) EXPECT_EQ(mine, got.front());
    EXPECT_EQ(*got.front(), "seven");
    EXPECT_EQ(*once.get(8, [] { return std::string("eight"); }), "eight") << "another key is another thing";
}

TEST(MadeOnce, WhatFailsIsTriedAgain) {
    MadeOnce<int, int> once;
    EXPECT_THROW(once.get(1, []() -> int { throw std::runtime_error("no memory"); }), std::runtime_error);
    EXPECT_EQ(*once.get(1, [] { return 5; }), 5);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "server/base/background.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include <sys/resource.h>
#include <unistd.h>

namespace heliograph::TEST_FILE {
namespace {

int niceOfThisThread() { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); }

TEST(Background, TheWorkIsNicerThanWhoAsksForItAndHeStaysAsHeWas) {
    const int before = niceOfThisThread();
    int inside = before;
    inBackground([&] { inside = niceOfThisThread(); });
    EXPECT_EQ(inside, std::min(before + BACKGROUND_NICE, 19));
    EXPECT_EQ(niceOfThisThread(), before);
}

TEST(Background, WhatTheWorkThrowsComesOut) {
    EXPECT_THROW(inBackground([] { throw std::invalid_argument("no"); }), std::invalid_argument);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

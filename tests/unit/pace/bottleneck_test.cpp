#include "server/pace/bottleneck.h"

#include <gtest/gtest.h>

#include <string>

namespace heliograph::TEST_FILE {
namespace {

TEST(Bottleneck, IsWhoeverHoldsPicturesUpMost) {
    EXPECT_EQ(bottleneckOf({}), Bottleneck::none);
    EXPECT_EQ(bottleneckOf({true, 0, 0.01, 0.01}), Bottleneck::server);
    EXPECT_EQ(bottleneckOf({true, 2, 0.03, 0.01}), Bottleneck::line) << "it would be one at a better quality";
    EXPECT_EQ(bottleneckOf({true, 0, 0.05, 0.03}), Bottleneck::line);
    EXPECT_EQ(bottleneckOf({false, 0, 0.01, 0.09}), Bottleneck::viewer);
    EXPECT_EQ(bottleneckOf({false, 0, 0.01, 0.01, true}), Bottleneck::line) << "a video, which JPEG was too large for";
    EXPECT_EQ(bottleneckOf({true, 0, 0.01, 0.01, true}), Bottleneck::server);
    EXPECT_EQ(std::string(wordOf(Bottleneck::viewer)), "viewer");
    EXPECT_EQ(std::string(wordOf(Bottleneck::none)), "none");
}

}  // namespace
}  // namespace heliograph::TEST_FILE

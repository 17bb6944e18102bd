#include "server/film/error_model.h"

#include <gtest/gtest.h>

#include <vector>

namespace heliograph::TEST_FILE {
namespace {

/// Doublings of a picture that the model fits, up to so many samples.
std::vector<Doubling> doublingsOf(double share, uint32_t last) {
    std::vector<Doubling> doublings;
    for (uint32_t n = 2; n <= last; n *= 2) doublings.push_back({n, errorDecay(n / 2, share) - errorDecay(n, share)});
    return doublings;
}

TEST(ErrorModel, ErrorsFallWithSamples) {
    for (double share : {0.0, 0.5, 1.0}) {
        for (uint32_t n = 1; n < 65536; n *= 2) EXPECT_LT(errorDecay(2 * n, share), errorDecay(n, share)) << n;
        EXPECT_GT(errorDecay(65536, share), errorDecay(1u << 20, share)) << "beyond the table";
    }
    EXPECT_EQ(otherDecay(1), 1.0);
    EXPECT_NEAR(edgeDecay(20) * edgeDecay(24) / (edgeDecay(16) * edgeDecay(30)), 1.0, 1e-9) << "a power between 16 and 32";
}

TEST(ErrorModel, KnowsNothingWithoutDoublings) {
    EXPECT_EQ(edgeShare({}), USUAL_EDGE_SHARE);
    EXPECT_EQ(edgeShare(doublingsOf(0.1, FIRST_DOUBLING / 2)), USUAL_EDGE_SHARE);
}

// The more doublings, the less the usual share counts.
TEST(ErrorModel, FindsTheShareThatThereIs) {
    for (double share : {0.0, 0.3, 0.6, 1.0}) {
        EXPECT_NEAR(edgeShare(doublingsOf(share, 256)), share, 0.08) << share;
        EXPECT_NEAR(edgeShare(doublingsOf(share, 4096)), share, 0.03) << share;
    }
}

TEST(ErrorModel, SharesStaySharesWhateverMoves) {
    const Doubling none{64, 0.0}, much{64, 10.0};
    for (const Doubling& doubling : {none, much}) {
        const double share = edgeShare({&doubling, 1});
        EXPECT_GE(share, 0.0);
        EXPECT_LE(share, 1.0);
    }
}

}  // namespace
}  // namespace heliograph::TEST_FILE

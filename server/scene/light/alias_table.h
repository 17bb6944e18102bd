#pragma once
// Choosing one of many by weight in constant time. Private to server/scene.

#include <cstdint>
#include <vector>

namespace heliograph {

/// One entry: chosen as often as each other one, it stands for itself below `threshold` and for `alias` above.
struct AliasEntry {
    float threshold = 1.0f;  // in [0, 1]
    uint32_t alias = 0;
};

/// Entries by which i is chosen with probability weights[i] / sum. Weights >= 0; empty if their sum is not positive and
/// finite. Walker, "An Efficient Method for Generating Discrete Random Variables with General Distributions" (1977); built
/// as Vose does, "A Linear Algorithm for Generating Random Numbers with a Given Distribution" (1991).
std::vector<AliasEntry> aliasTable(const std::vector<double>& weights);

}  // namespace heliograph

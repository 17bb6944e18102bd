#include "server/scene/light/alias_table.h"

#include <cmath>

namespace heliograph {

std::vector<AliasEntry> aliasTable(const std::vector<double>& weights) {
    double sum = 0.0;
    for (const double weight : weights) sum += weight;
    if (!(sum > 0.0) || !std::isfinite(sum)) return {};
    std::vector<AliasEntry> table(weights.size());
    std::vector<double> share(weights.size());
    std::vector<uint32_t> small, large;
    for (uint32_t i = 0; i < weights.size(); i++) {
        share[i] = weights[i] / sum * static_cast<double>(weights.size());
        (share[i] < 1.0 ? small : large).push_back(i);
        table[i].alias = i;
    }
    while (!small.empty() && !large.empty()) {
        const uint32_t poor = small.back(), rich = large.back();
        small.pop_back();
        table[poor] = {static_cast<float>(share[poor]), rich};
        share[rich] -= 1.0 - share[poor];
        if (share[rich] < 1.0) {
            large.pop_back();
            small.push_back(rich);
        }
    }
    return table;
}

}  // namespace heliograph

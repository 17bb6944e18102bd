#include "server/film/adaptive_plan.h"

#include <algorithm>

namespace heliograph {

namespace {

/// Samples of the chosen cell that is farthest; `least`: of the one that is behind most.
uint32_t mostOf(const std::vector<CellError>& errors, const std::vector<bool>& chosen, uint32_t least) {
    for (size_t i = 0; i < errors.size(); i++) {
        if (chosen[i]) least = std::max(least, errors[i].samples);
    }
    return least;
}

}  // namespace

bool AdaptivePlan::follow(const Film& film, const CellCosts& costs, const AdaptiveGoal& goal) {
    constexpr uint32_t GROWTH = 16;  // of the samples, by a part of so many
    if (film.completedSamples() < ADAPTIVE_FROM) {
        const bool had = cells_.has_value();
        forget();
        return had;
    }
    if (cells_ && goal == goal_ && finished()) return false;
    if (cells_ && goal == goal_ && stands_ > 0) return stands_--, false;
    std::vector<CellError> errors = film.errorParts();
    if (costs.cells() == film.cellCount()) {
        for (uint32_t i = 0; i < errors.size(); i++) errors[i].cost = std::max(1.0, static_cast<double>(costs.predicted(i)));
    }
    goal_ = goal;
    // A black picture has nothing to refine by: it gets what was asked for everywhere.
    const bool more = film.completedSamples() < goal.mostSamples;
    cells_ = errors.empty() ? std::vector<bool>(static_cast<size_t>(film.cellCount().x) * film.cellCount().y, more)
                            : cellsToRefine(errors, goal.error, film.edgeShare(), goal.mostSamples);
    chosen_ = static_cast<size_t>(std::ranges::count(*cells_, true));
    uint32_t least = goal.mostSamples;
    for (size_t i = 0; i < errors.size(); i++) {
        if ((*cells_)[i]) least = std::min(least, errors[i].samples);
    }
    // Never past the most by the passes that it stands.
    stands_ = errors.empty() ? 0 : std::min(least / GROWTH, goal.mostSamples - mostOf(errors, *cells_, least) - 1);
    return true;
}

}  // namespace heliograph

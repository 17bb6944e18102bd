#pragma once
// Which cells of a film with an error target the next pass is for: asked before each pass, thought over anew where the samples since
// then may tell something else.

#include "server/film/cell_costs.h"
#include "server/film/film.h"

#include <optional>

namespace heliograph {

/// What a picture is to come to.
struct AdaptiveGoal {
    double error = 0.0;        // relative
    uint32_t mostSamples = 0;  // of any pixel
    bool operator==(const AdaptiveGoal&) const = default;
};

class AdaptivePlan {
public:
    /// Nothing is planned; for another film.
    void forget() { *this = AdaptivePlan(); }
    /// Looks at the film, before a pass. True where the plan was made anew, or given up as a block has less than ADAPTIVE_FROM samples.
    /// `costs`: of the film's cells, where they are known.
    bool follow(const Film& film, const CellCosts& costs, const AdaptiveGoal& goal);
    /// Cells of Film::tilesFor; null: all of them, as there is no plan.
    const std::vector<bool>* cells() const { return cells_ ? &*cells_ : nullptr; }
    /// No cell is to get any more.
    bool finished() const { return cells_ && chosen_ == 0; }
    /// Part of the cells that get more, 0 to 1.
    double share() const { return cells_ ? static_cast<double>(chosen_) / static_cast<double>(cells_->size()) : 1.0; }

private:
    AdaptiveGoal goal_;
    std::optional<std::vector<bool>> cells_;
    size_t chosen_ = 0;
    uint32_t stands_ = 0;  // passes for which it is not thought over
};

}  // namespace heliograph

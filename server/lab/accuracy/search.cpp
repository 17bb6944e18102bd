// The part of the sweep that looks for combinations: coordinate steps from the front.
//
// The front of all that is measured is walked from fast to slow, and the first of its points that has not been left yet is
// left in every direction: each knob of kinds grain and cut one step dearer and one step cheaper, each combination once. What
// is found there joins the points, and the front is made anew. So the front is filled evenly as far as the budget goes, and no
// point is tried that lies far from what was best so far.

#include "server/lab/accuracy/sweep.h"

#include "server/base/text.h"

#include <algorithm>
#include <set>

namespace heliograph {

namespace {

/// The settings with one knob a step further, in each direction.
std::vector<Settings> neighbours(const Settings& from, const Knob& knob) {
    const std::string now = valueOf(from, knob);
    const auto at = std::ranges::find(knob.values, now);
    std::vector<Settings> steps;
    if (at == knob.values.end()) return steps;
    if (at != knob.values.begin()) steps.push_back(turned(from, knob, *(at - 1)));
    // Without a threshold and with high limits glass would take for ever.
    const bool endless = knob.setting == "contributionThreshold" && at + 2 == knob.values.end();
    if (at + 1 != knob.values.end() && !endless) steps.push_back(turned(from, knob, *(at + 1)));
    return steps;
}

std::vector<std::string> differences(const Settings& from, const Settings& to) {
    std::vector<std::string> set;
    for (const Knob& knob : knobs()) {
        const std::string before = valueOf(from, knob), after = valueOf(to, knob);
        if (before != after) set.push_back(std::string(knob.setting) + "=" + after);
    }
    return set;
}

}  // namespace

void AccuracySweep::search(const Progress& progress) {
    std::vector<const Knob*> free;
    for (const Knob& knob : knobs()) {
        const bool swept = std::ranges::any_of(rows_, [&](const AccuracyRow& row) { return row.knob == knob.setting; });
        if (swept && (knob.kind == KnobKind::grain || knob.kind == KnobKind::cut || knob.kind == KnobKind::filter))
            free.push_back(&knob);
    }
    std::set<size_t> left;  // points
    while (!over(1.0)) {
        const std::vector<size_t> best = front();
        const auto next = std::ranges::find_if(best, [&](size_t row) { return !left.contains(rows_[row].point); });
        if (next == best.end()) return;  // every point of the front has been left in every direction
        const size_t from = rows_[*next].point;
        for (const Knob* knob : free) {
            for (const Settings& settings : neighbours(points_[from].settings, *knob)) {
                if (over(1.0)) return;
                if (!allowed(settings)) continue;
                const size_t known = points_.size();
                const size_t index = pointOf(differences(options_.settings, settings), settings);
                if (index < known) continue;
                timeOnce(points_[index]);
                judge(points_[index], latest_);
                rows_.push_back({"combination", joined(points_[index].set, " "), false, false, index});
                say(progress, rows_.back().value);
                step();
            }
        }
        left.insert(from);
    }
}

size_t AccuracySweep::measure(const Settings& settings, const Progress& progress) {
    const size_t index = pointOf(differences(options_.settings, settings), settings);
    AccuracyPoint& point = points_[index];
    while (point.time.first.wallMs.size() < options_.repetitions) timeOnce(point);
    if (!point.measured) judge(point, latest_);
    const auto row = std::ranges::find(rows_, index, &AccuracyRow::point);
    const auto found = static_cast<size_t>(row - rows_.begin());
    if (row == rows_.end()) rows_.push_back({"combination", joined(point.set, " "), false, false, index});
    say(progress, rows_[found].value);
    step();
    return found;
}

}  // namespace heliograph

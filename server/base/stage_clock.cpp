#include "server/base/stage_clock.h"

#include <algorithm>

namespace heliograph {

std::vector<std::string> stuckStages(std::span<const RunningStage> stages, double limit) {
    std::vector<RunningStage> stuck;
    std::ranges::copy_if(stages, std::back_inserter(stuck), [&](const RunningStage& stage) { return stage.seconds > limit; });
    std::ranges::stable_sort(stuck, std::ranges::greater(), &RunningStage::seconds);
    std::vector<std::string> names;
    names.reserve(stuck.size());
    for (const RunningStage& stage : stuck) names.push_back("viewer " + std::to_string(stage.viewer) + ", " + stage.name);
    return names;
}

}  // namespace heliograph

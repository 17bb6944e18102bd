#include "server/operations/readiness.h"

#include "server/base/text.h"

#include <nlohmann/json.hpp>

namespace heliograph {

std::optional<NotReady> notReady(const ReadinessFacts& facts) {
    if (facts.ending) return NotReady{"draining", "the server ends"};
    if (facts.closed) return NotReady{"draining", "an admin lets nobody else in"};
    if (!facts.stuck.empty()) {
        std::string names;
        for (const std::string& name : facts.stuck) names += (names.empty() ? "" : ", ") + name;
        return NotReady{"stuck", names + ": has not moved for long"};
    }
    if (!facts.sceneFailure.empty()) return NotReady{"scene", oneLine(facts.sceneFailure)};
    if (!facts.sceneThere) return NotReady{"loading", oneLine(facts.scene) + " is not loaded yet"};
    if (facts.viewers >= facts.mostViewers)
        return NotReady{"full", std::to_string(facts.viewers) + " of " + std::to_string(facts.mostViewers) + " viewers"};
    if (!facts.crowded.empty()) return NotReady{"full", facts.crowded};
    return std::nullopt;
}

std::string readinessJson(const std::optional<NotReady>& state) {
    nlohmann::ordered_json json = {{"ready", !state.has_value()}};
    if (state) json.update({{"reason", state->reason}, {"message", state->message}});
    return json.dump() + "\n";
}

}  // namespace heliograph

#pragma once
// What a picture in a hurry does without, in which order: the cheapest steps toward fast first by what they cost in error for the time
// they save (docs/measurements/accuracy.md). A pure function of settings and effects; who takes which rung, and when, is decided in
// pace/autopilot.h.

#include "server/request/effects.h"

#include <string>
#include <vector>

namespace heliograph {

/// A rung has all changes of those above it, too.
struct LadderRung {
    Settings settings;
    std::string setting, before, after;  // what it changes against the one above, spelled as for --set; empty on the first
    double share = 1.0;                  // of the first one's rays, weighed by what they usually cost
};

/// From the settings as given downwards; what changes nothing under these settings and effects of the scene is no rung. The scale is
/// none either.
std::vector<LadderRung> ladderOf(const Settings& settings, EffectSet scene);

}  // namespace heliograph

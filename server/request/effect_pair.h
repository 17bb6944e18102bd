#pragma once
// What one effect costs, as two requests: the same view with and without it. The lab and a viewer's effect meter render
// both and compare (lab/effect_bench, loop/effect_meter). Pure functions.

#include "server/request/effect_rules.h"
#include "server/request/frame_request.h"

namespace heliograph {

struct EffectPair {
    EffectReason effect;
    FrameRequest on;   // the effect's switch is on, whatever the settings said
    FrameRequest off;  // the same request without the effect's bit
    /// False where the scene does not call for the effect: both requests then ask for the same.
    bool differs() const { return !(on.effects == off.effects); }
};

/// One pair per row of `effects`, the scene's. `base` gives camera, settings and resolution; its own effects do not count.
std::vector<EffectPair> effectPairs(const std::vector<EffectReason>& effects, const FrameRequest& base);

/// Settings that allow everything: each switch of an effect that is on by default is on. Switches that are off by default
/// (ambient occlusion) are a viewer's choice, no scene's, and stay as they are.
Settings withAllAllowed(Settings settings);
/// Settings that allow what the scene calls for and nothing else: switches none of whose effects is called for are off.
Settings withOnlyCalledFor(Settings settings, const std::vector<EffectReason>& effects);

}  // namespace heliograph

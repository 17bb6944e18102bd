#pragma once
// Which effects a scene calls for, and why: one rule per row of effect_table.glsl, found by the row's name.

#include "server/request/effects.h"
#include "server/scene/scene.h"

namespace heliograph {

struct EffectReason {
    std::string name;
    uint64_t bit = 0;
    bool calledFor = false;  // by the scene
    std::string because;     // which material, light or image, and how many triangles; or what is lacking
    std::string setting;     // that switches it, or ""
    std::string help;
    bool simulated = true;  // false: no device can; bit is 0
    bool choice = false;    // the scene asks for nothing, but shows it where the viewer wants it
    /// Whether it can make a difference.
    bool possible() const { return calledFor || choice; }
};

/// One row per effect of the table, then those that files may call for and nothing here simulates yet.
std::vector<EffectReason> explainEffects(const Scene& scene);
/// The bits of the rows that the scene calls for, and of those that it leaves to the viewer.
EffectSet possibleEffects(const std::vector<EffectReason>& effects);
/// possibleEffects of the scene.
EffectSet effectsOf(const Scene& scene);

}  // namespace heliograph

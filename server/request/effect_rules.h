#pragma once
// Which effects a scene calls for, and why: one rule per row of effect_table.glsl, found by the row's name.

#include "server/request/effects.h"
#include "server/scene/scene.h"

namespace heliograph {

struct EffectReason {
    std::string name;
    uint32_t bit = 0;
    bool calledFor = false;
    std::string because;  // which material, light or image, and how many triangles; or what is lacking
    std::string setting;  // that switches it, or ""
    std::string help;
    bool simulated = true;  // false: no device can; bit is 0
};

/// One row per effect of the table, then those that files may call for and nothing here simulates yet.
std::vector<EffectReason> explainEffects(const Scene& scene);
/// The bits of the rows that the scene calls for.
EffectSet calledFor(const std::vector<EffectReason>& effects);
/// The effects that the scene calls for.
EffectSet effectsOf(const Scene& scene);

}  // namespace heliograph

#pragma once
// Which effects a scene calls for, and why; and which of them a request then uses.

#include "server/request/settings.h"
#include "server/scene/scene.h"

namespace heliograph {

/// A set of EFFECT_* bits.
struct EffectSet {
    uint32_t bits = 0;
    bool has(uint32_t effect) const { return (bits & effect) != 0; }
    bool operator==(const EffectSet&) const = default;
};

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
/// The effects that the settings allow.
EffectSet allowedEffects(const Settings& settings);
/// Names of the effects in the set, in table order.
std::vector<std::string> effectNames(EffectSet effects);

}  // namespace heliograph

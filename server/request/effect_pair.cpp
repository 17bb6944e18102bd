#include "server/request/effect_pair.h"

#include <algorithm>

namespace heliograph {

std::vector<EffectPair> effectPairs(const std::vector<EffectReason>& effects, const FrameRequest& base) {
    const EffectSet called = calledFor(effects);
    std::vector<EffectPair> pairs;
    for (const EffectReason& effect : effects) {
        if (!effect.simulated) continue;
        EffectPair pair{effect, base, base};
        if (!effect.setting.empty()) pair.on.settings.set(effect.setting, true);
        pair.on.effects.bits = called.bits & allowedEffects(pair.on.settings).bits;
        pair.off = pair.on;
        pair.off.effects.bits &= ~effect.bit;
        pairs.push_back(std::move(pair));
    }
    return pairs;
}

Settings withAllAllowed(Settings settings) {
    const Settings defaults;
    for (const EffectRow& row : effectRows()) {
        if (row.allowedBy && defaults.*row.allowedBy) settings.*row.allowedBy = true;
    }
    return settings;
}

Settings withOnlyCalledFor(Settings settings, const std::vector<EffectReason>& effects) {
    for (const EffectReason& effect : effects) {
        if (effect.setting.empty()) continue;
        bool needed = std::any_of(effects.begin(), effects.end(), [&](const EffectReason& other) {
            return other.setting == effect.setting && other.calledFor;
        });
        if (!needed) settings.set(effect.setting, false);
    }
    return settings;
}

}  // namespace heliograph

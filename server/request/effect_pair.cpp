#include "server/request/effect_pair.h"

#include <algorithm>

namespace heliograph {

namespace {

/// Allows or forbids the effect by its switch, or by the first choice that does.
void allow(const EffectReason& effect, bool allowed, Settings& settings) {
    const auto row = std::ranges::find(effectRows(), effect.bit, &EffectRow::bit);
    if (row == effectRows().end()) return;
    if (row->allowedBy) settings.*row->allowedBy = allowed;
    if (row->chosenBy) settings.*row->chosenBy = allowed ? 1 : 0;
}

}  // namespace

std::vector<EffectPair> effectPairs(const std::vector<EffectReason>& effects, const FrameRequest& base) {
    const EffectSet called = possibleEffects(effects);
    std::vector<EffectPair> pairs;
    for (const EffectReason& effect : effects) {
        if (!effect.simulated) continue;
        EffectPair pair{effect, base, base};
        allow(effect, true, pair.on.settings);
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
            return other.setting == effect.setting && other.possible();
        });
        if (!needed) allow(effect, false, settings);
    }
    return settings;
}

}  // namespace heliograph

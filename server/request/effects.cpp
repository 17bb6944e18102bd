#include "server/request/effects.h"

namespace heliograph {

namespace {

/// What a row may name as a setting: one of the settings, or `none`.
struct Named : Settings {
    bool none;
};

using Switch = bool Settings::*;
using Choice = uint32_t Settings::*;
using Amount = float Settings::*;
constexpr Switch switchOf(Switch setting) { return setting; }
constexpr Switch switchOf(bool Named::*) { return nullptr; }
constexpr Switch switchOf(Choice) { return nullptr; }
constexpr Choice choiceOf(Choice setting) { return setting; }
constexpr Choice choiceOf(Switch) { return nullptr; }
constexpr Choice choiceOf(bool Named::*) { return nullptr; }
constexpr Amount amountOf(Amount setting) { return setting; }
constexpr Amount amountOf(bool Named::*) { return nullptr; }

constexpr EffectRow EFFECT_ROWS[] = {
#define EFFECT(bit, CONSTANT, name, setting, parent, positive, rule, tier, help) \
    {CONSTANT,                                                                   \
     #name,                                                                      \
     std::string_view(#setting) == "none" ? "" : std::string_view(#setting),     \
     help,                                                                       \
     switchOf(&Named::setting),                                                  \
     choiceOf(&Named::setting),                                                  \
     parent,                                                                     \
     amountOf(&Named::positive)},
#include "shaders/kernel/effect_table.glsl"
};

// `allowedEffects` goes through the rows once.
#define EFFECT(bit, CONSTANT, name, setting, parent, positive, rule, tier, help) \
    static_assert((parent) < CONSTANT, #name ": its parent has to stand in an earlier row");
#include "shaders/kernel/effect_table.glsl"

}  // namespace

std::span<const EffectRow> effectRows() { return EFFECT_ROWS; }

EffectSet allowedEffects(const Settings& settings) {
    EffectSet allowed;
    for (const EffectRow& row : EFFECT_ROWS) {
        if (row.allowedBy && !(settings.*row.allowedBy)) continue;
        if (row.chosenBy && settings.*row.chosenBy == 0) continue;
        if (row.parent != 0 && !allowed.has(row.parent)) continue;
        if (row.positive && !(settings.*row.positive > 0.0f)) continue;
        allowed.bits |= row.bit;
    }
    return allowed;
}

std::vector<std::string> effectNames(EffectSet effects) {
    std::vector<std::string> names;
    for (const EffectRow& row : EFFECT_ROWS) {
        if (effects.has(row.bit)) names.emplace_back(row.name);
    }
    return names;
}

}  // namespace heliograph

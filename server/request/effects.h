#pragma once
// The effects as rows of effect_table.glsl, and which of them settings allow.

#include "server/request/settings.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

/// A set of EFFECT_* bits.
struct EffectSet {
    uint64_t bits = 0;
    /// The same as two words, as devices take them (FrameConstants).
    uint32_t low() const { return static_cast<uint32_t>(bits); }
    uint32_t high() const { return static_cast<uint32_t>(bits >> 32); }
    bool has(uint64_t effect) const { return (bits & effect) != 0; }
    bool operator==(const EffectSet&) const = default;
};

/// One row of the table.
struct EffectRow {
    uint64_t bit = 0;  // EFFECT_*
    std::string_view name;
    std::string_view setting;  // name of `allowedBy` or `chosenBy`, or ""
    std::string_view help;
    bool Settings::*allowedBy = nullptr;     // the switch; null: always allowed
    uint32_t Settings::*chosenBy = nullptr;  // a choice that allows it where it is not 0; null: none
    uint64_t parent = 0;                     // EFFECT_* that must be allowed too; 0: none
    float Settings::*positive = nullptr;     // setting that must be above 0; null: none
};

/// All rows, in the table's order, which is that of their bits.
std::span<const EffectRow> effectRows();
/// The effects that the settings allow.
EffectSet allowedEffects(const Settings& settings);
/// Names of the effects in the set, in table order.
std::vector<std::string> effectNames(EffectSet effects);

}  // namespace heliograph

#pragma once
// What an operator lets viewers set at most, below the ranges of the settings' table. Pure functions.

#include "server/request/settings.h"

#include <optional>

namespace heliograph {

struct SettingCaps {
    uint32_t samples = 65536;  // per pixel at rest
    uint32_t rays = 256;       // of one kind per visible point and sample: shadowSamples, aoSamples, fogSamples
    uint32_t bounces = 31;     // in a row: maxReflections, maxRefractions
};

/// The largest value of the setting under the caps, nothing for a setting that has none.
std::optional<uint32_t> capOf(std::string_view setting, const SettingCaps& caps);
/// Throws InputError naming the first setting beyond its cap, the value and the range.
void checkCaps(const Settings& settings, const SettingCaps& caps);
/// The settings, those beyond their caps lowered to them.
Settings capped(Settings settings, const SettingCaps& caps);
/// settingsSchema with the caps as `high` and with defaults within them.
nlohmann::json cappedSchema(const SettingCaps& caps);

}  // namespace heliograph

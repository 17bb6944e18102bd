#pragma once
// What a viewer or a command can set. Fields, JSON names, ranges and help all come from settings_table.glsl.

#include "server/kernel/kernel_types.h"

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

struct Settings {
#define SETTING_BOOL(name, def, label, effect, price, help) bool name = def;
#define SETTING_INT(name, def, low, high, unit, label, effect, price, help) uint32_t name = def;
#define SETTING_FLOAT(name, def, low, high, unit, label, effect, price, help) float name = def;
#define SETTING_CHOICE(name, def, choices, label, effect, price, help) uint32_t name = def;
#define SETTING_K_INT SETTING_INT
#define SETTING_K_FLOAT SETTING_FLOAT
#include "shaders/kernel/settings_table.glsl"
#undef SETTING_BOOL
#undef SETTING_INT
#undef SETTING_FLOAT
#undef SETTING_CHOICE
#undef SETTING_K_INT
#undef SETTING_K_FLOAT

    bool operator==(const Settings&) const = default;

    /// Sets one field from JSON: bool, number, or for a choice its word or a number that spells it. Throws InputError
    /// naming field, found value and range; nothing has changed then.
    void set(std::string_view name, const nlohmann::json& value);
    /// Sets one field from `key=value` as given on a command line and returns its name. Throws InputError.
    std::string setFromText(std::string_view keyEqualsValue);
    /// All fields by name; choices as their word.
    nlohmann::json toJson() const;
    /// The word of a choice setting's present value.
    /// Throws std::out_of_range for an unknown choice setting or value.
    static std::string choiceWord(std::string_view name, uint32_t value);
};

/// Size of a CPU tile in pixels, multiples of 8. With `tiles` off: rows wider than any picture (Film::tilesFor cuts them).
uvec2 tileSize(const Settings& settings);

/// The table as JSON for the client's form: [{name, type: bool|int|float|choice, default, low, high, unit, label, effect,
/// price, help, choices?}].
nlohmann::json settingsSchema();

}  // namespace heliograph

#pragma once
// What a viewer or a command can set. Fields, JSON names, ranges and help all come from settings_table.glsl.

#include "server/kernel/kernel_types.h"

#include <nlohmann/json.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

/// What a setting changes (column `acts` of the table).
enum class Acts {
    film,     // the samples: another value asks for another film
    display,  // the picture that is made of the film
    loop,     // how many samples and pixels the film shall have by when
    command,  // the view of commands; a viewer has messages of its own for it
};

/// Choices of the setting `device`.
inline constexpr std::string_view DEVICE_WORDS =
    "auto"
#define DEVICE(name, bit, kind, side, words, onSwitch, standIn, make) "|" words
#include "server/request/device_table.inc"
    "|hybrid";

struct Settings {
#define SETTING_BOOL(name, group, acts, def, label, effect, price, help) bool name = def;
#define SETTING_INT(name, group, acts, def, low, high, unit, label, effect, price, help) uint32_t name = def;
#define SETTING_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help) float name = def;
#define SETTING_CHOICE(name, group, acts, def, choices, label, effect, price, help) uint32_t name = def;
#include "shaders/kernel/settings_table.glsl"

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
    /// Value of the choice setting `name` that its row spells `word`. Does not compile for a name or a word that no row has.
    static consteval uint32_t choice(std::string_view name, std::string_view word);
};

/// The table's choice settings.
struct ChoiceRow {
    std::string_view name;
    std::string_view words;  // "a|b|c"
};
inline constexpr ChoiceRow CHOICE_ROWS[] = {
#define SETTING_CHOICE(name, group, acts, def, choices, label, effect, price, help) {#name, choices},
#include "shaders/kernel/settings_table.glsl"
};

consteval uint32_t Settings::choice(std::string_view name, std::string_view word) {
    for (const ChoiceRow& row : CHOICE_ROWS) {
        if (row.name != name) continue;
        std::string_view rest = row.words;
        for (uint32_t value = 0;; value++) {
            const size_t end = rest.find('|');
            if (rest.substr(0, end) == word) return value;
            if (end == std::string_view::npos) break;
            rest.remove_prefix(end + 1);
        }
    }
    throw "no such choice";
}

/// What the setting changes. Throws InputError for an unknown name.
Acts actsOf(std::string_view name);
/// The settings that act so, all others at their defaults.
Settings onlyActing(const Settings& settings, Acts acts);

/// Size of a CPU tile in pixels, multiples of 8. With `tiles` off: rows wider than any picture (Film::tilesFor cuts them).
uvec2 tileSize(const Settings& settings);

/// The table as JSON for the client's form: [{name, type: bool|int|float|choice, default, low, high, unit, label, effect,
/// price, help, group: picture|effects|renderer|hybrid, acts: film|display|loop|command, choices?}].
nlohmann::json settingsSchema();

}  // namespace heliograph

#include "server/request/settings.h"

#include "server/base/error.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <variant>

namespace heliograph {

namespace {

using Field = std::variant<bool Settings::*, uint32_t Settings::*, float Settings::*>;

/// One row of settings_table.glsl.
struct SettingsRow {
    enum class Type { boolean, integer, real, choice };
    std::string_view name;
    std::string_view group;
    Acts acts;
    std::string_view actsWord;
    Type type;
    Field field;
    double initial;
    double low;
    double high;
    std::string_view unit;
    std::string_view choices;  // "a|b|c", choice alone
    std::string_view label;
    std::string_view effect;
    std::string_view price;
    std::string_view help;
};

constexpr SettingsRow SETTINGS_ROWS[] = {
#define SETTING_BOOL(name, group, acts, def, label, effect, price, help)                               \
    {#name, #group, Acts::acts, #acts, SettingsRow::Type::boolean, &Settings::name, def, 0, 1, "", "", \
     label, effect, price,      help},
#define SETTING_INT(name, group, acts, def, low, high, unit, label, effect, price, help)                      \
    {#name, #group, Acts::acts, #acts, SettingsRow::Type::integer, &Settings::name, def, low, high, unit, "", \
     label, effect, price,      help},
#define SETTING_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help)                 \
    {#name, #group, Acts::acts, #acts, SettingsRow::Type::real, &Settings::name, def, low, high, unit, "", \
     label, effect, price,      help},
#define SETTING_CHOICE(name, group, acts, def, choices, label, effect, price, help)                        \
    {#name, #group, Acts::acts, #acts, SettingsRow::Type::choice, &Settings::name, def, 0, 0, "", choices, \
     label, effect, price,      help},
#include "shaders/kernel/settings_table.glsl"
};

std::vector<std::string> wordsOf(std::string_view choices) {
    std::vector<std::string> words;
    size_t begin = 0;
    while (true) {
        size_t end = choices.find('|', begin);
        words.emplace_back(choices.substr(begin, end - begin));
        if (end == std::string_view::npos) return words;
        begin = end + 1;
    }
}

/// A number as people write it: no exponent for what has none, no trailing zeros. Floats keep the digits they were given.
std::string spelled(double value) {
    std::ostringstream text;
    text.precision(7);
    text << value;
    return text.str();
}

/// The double with the fewest digits that is this float again: 0.004f is 0.004 in the form and in --json, not
/// 0.004000000189989805.
double asJsonNumber(float value) {
    char text[32];
    const char* end = std::to_chars(text, text + sizeof text, value).ptr;
    double number = 0.0;
    std::from_chars(text, end, number);
    return number;
}

std::string allowed(const SettingsRow& row) {
    std::string unit = row.unit.empty() ? "" : " (" + std::string(row.unit) + ")";
    switch (row.type) {
        case SettingsRow::Type::boolean: return "true or false";
        case SettingsRow::Type::integer: return "a whole number from " + spelled(row.low) + " to " + spelled(row.high) + unit;
        case SettingsRow::Type::real: return "a number from " + spelled(row.low) + " to " + spelled(row.high) + unit;
        case SettingsRow::Type::choice: break;
    }
    std::string list = "one of";
    for (const std::string& word : wordsOf(row.choices)) list += " " + word;
    return list;
}

[[noreturn]] void refuse(const SettingsRow& row, const std::string& found) {
    throw InputError("setting " + std::string(row.name), found, allowed(row));
}

/// JSON as shown in a message: one line, not longer than a line.
std::string shown(const nlohmann::json& value) {
    std::string text = value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

const SettingsRow& rowNamed(std::string_view name) {
    for (const SettingsRow& row : SETTINGS_ROWS) {
        if (row.name == name) return row;
    }
    std::string list = "one of";
    for (const SettingsRow& row : SETTINGS_ROWS) list += " " + std::string(row.name);
    throw InputError("setting", "unknown name " + shown(std::string(name)), list);
}

uint32_t choiceIndex(const SettingsRow& row, const nlohmann::json& value) {
    std::string word;
    if (value.is_string()) word = value.get<std::string>();
    if (value.is_number()) word = spelled(value.get<double>());
    std::vector<std::string> words = wordsOf(row.choices);
    for (size_t i = 0; i < words.size(); i++) {
        if (!word.empty() && words[i] == word) return static_cast<uint32_t>(i);
    }
    refuse(row, shown(value));
}

/// Of the forms that a command line offers, the JSON value that the row's type asks for. Text that is none stays text and
/// is refused by `set`.
nlohmann::json parsed(const SettingsRow& row, const std::string& text) {
    if (row.type == SettingsRow::Type::choice) return text;
    if (row.type == SettingsRow::Type::boolean) {
        if (text == "true" || text == "on" || text == "yes" || text == "1") return true;
        if (text == "false" || text == "off" || text == "no" || text == "0") return false;
        return text;
    }
    double number = 0.0;
    auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return text;
    return number;
}

}  // namespace

void Settings::set(std::string_view name, const nlohmann::json& value) {
    const SettingsRow& row = rowNamed(name);
    if (row.type == SettingsRow::Type::boolean) {
        if (!value.is_boolean()) refuse(row, shown(value));
        this->*std::get<bool Settings::*>(row.field) = value.get<bool>();
        return;
    }
    if (row.type == SettingsRow::Type::choice) {
        this->*std::get<uint32_t Settings::*>(row.field) = choiceIndex(row, value);
        return;
    }
    if (!value.is_number()) refuse(row, shown(value));
    double number = value.get<double>();
    // Written so that NaN is refused too.
    if (!(number >= row.low && number <= row.high)) refuse(row, shown(value));
    if (row.type == SettingsRow::Type::real) {
        this->*std::get<float Settings::*>(row.field) = static_cast<float>(number);
        return;
    }
    if (number != std::floor(number)) refuse(row, shown(value));
    this->*std::get<uint32_t Settings::*>(row.field) = static_cast<uint32_t>(number);
}

std::string Settings::setFromText(std::string_view keyEqualsValue) {
    size_t equals = keyEqualsValue.find('=');
    if (equals == std::string_view::npos || equals == 0) {
        throw InputError("--set", shown(std::string(keyEqualsValue)), "key=value, for example samples=64");
    }
    std::string key(keyEqualsValue.substr(0, equals));
    set(key, parsed(rowNamed(key), std::string(keyEqualsValue.substr(equals + 1))));
    return key;
}

nlohmann::json Settings::toJson() const {
    nlohmann::json values = nlohmann::json::object();
    for (const SettingsRow& row : SETTINGS_ROWS) {
        std::string name(row.name);
        if (row.type == SettingsRow::Type::boolean) {
            values[name] = this->*std::get<bool Settings::*>(row.field);
        } else if (row.type == SettingsRow::Type::real) {
            values[name] = asJsonNumber(this->*std::get<float Settings::*>(row.field));
        } else {
            uint32_t number = this->*std::get<uint32_t Settings::*>(row.field);
            if (row.type == SettingsRow::Type::choice) values[name] = choiceWord(row.name, number);
            else values[name] = number;
        }
    }
    return values;
}

std::string Settings::choiceWord(std::string_view name, uint32_t value) {
    for (const SettingsRow& row : SETTINGS_ROWS) {
        if (row.name == name && row.type == SettingsRow::Type::choice) return wordsOf(row.choices).at(value);
    }
    throw std::out_of_range("no choice setting " + std::string(name));
}

Acts actsOf(std::string_view name) { return rowNamed(name).acts; }

Settings onlyActing(const Settings& settings, Acts asked) {
    Settings only;
#define SETTING(name, group, acts) \
    if (Acts::acts == asked) only.name = settings.name;
#include "shaders/kernel/settings_table.glsl"
    return only;
}

uvec2 tileSize(const Settings& settings) {
    if (!settings.tiles) return uvec2(1u << 16, 8u);
    static_assert(Settings::choice("tileWidth", "8") == 0 && Settings::choice("tileWidth", "256") == 5);
    static_assert(Settings::choice("tileHeight", "8") == 0 && Settings::choice("tileHeight", "256") == 5);
    return uvec2(8u << settings.tileWidth, 8u << settings.tileHeight);
}

nlohmann::json settingsSchema() {
    static const char* const TYPES[] = {"bool", "int", "float", "choice"};
    nlohmann::json schema = nlohmann::json::array();
    const nlohmann::json defaults = Settings{}.toJson();
    for (const SettingsRow& row : SETTINGS_ROWS) {
        nlohmann::json entry = {{"name", row.name},
                                {"type", TYPES[static_cast<size_t>(row.type)]},
                                {"default", defaults.at(std::string(row.name))},
                                {"unit", row.unit},
                                {"label", row.label},
                                {"effect", row.effect},
                                {"price", row.price},
                                {"help", row.help},
                                {"group", row.group},
                                {"acts", row.actsWord}};
        bool range = row.type == SettingsRow::Type::integer || row.type == SettingsRow::Type::real;
        entry["low"] = range ? nlohmann::json(asJsonNumber(static_cast<float>(row.low))) : nlohmann::json(nullptr);
        entry["high"] = range ? nlohmann::json(asJsonNumber(static_cast<float>(row.high))) : nlohmann::json(nullptr);
        if (row.type == SettingsRow::Type::integer) {
            entry["low"] = static_cast<uint32_t>(row.low);
            entry["high"] = static_cast<uint32_t>(row.high);
        }
        if (row.type == SettingsRow::Type::choice) entry["choices"] = wordsOf(row.choices);
        schema.push_back(entry);
    }
    return schema;
}

}  // namespace heliograph

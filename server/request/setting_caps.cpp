#include "server/request/setting_caps.h"

#include "server/base/error.h"

#include <algorithm>

namespace heliograph {

namespace {

struct Row {
    std::string_view name;
    uint32_t Settings::*field;
    uint32_t SettingCaps::*cap;
};

constexpr Row ROWS[] = {
    {"samples", &Settings::samples, &SettingCaps::samples},
    {"shadowSamples", &Settings::shadowSamples, &SettingCaps::rays},
    {"aoSamples", &Settings::aoSamples, &SettingCaps::rays},
    {"fogSamples", &Settings::fogSamples, &SettingCaps::rays},
    {"maxReflections", &Settings::maxReflections, &SettingCaps::bounces},
    {"maxRefractions", &Settings::maxRefractions, &SettingCaps::bounces},
};

}  // namespace

std::optional<uint32_t> capOf(std::string_view setting, const SettingCaps& caps) {
    for (const Row& row : ROWS) {
        if (row.name == setting) return caps.*row.cap;
    }
    return std::nullopt;
}

void checkCaps(const Settings& settings, const SettingCaps& caps) {
    for (const Row& row : ROWS) {
        if (settings.*row.field <= caps.*row.cap) continue;
        throw InputError("settings." + std::string(row.name), std::to_string(settings.*row.field),
                         "at most " + std::to_string(caps.*row.cap) + " on this server");
    }
}

Settings capped(Settings settings, const SettingCaps& caps) {
    for (const Row& row : ROWS) settings.*row.field = std::min(settings.*row.field, caps.*row.cap);
    return settings;
}

nlohmann::json cappedSchema(const SettingCaps& caps) {
    nlohmann::json schema = settingsSchema();
    for (nlohmann::json& setting : schema) {
        const std::optional<uint32_t> cap = capOf(setting["name"].get<std::string>(), caps);
        if (!cap) continue;
        for (const char* field : {"high", "default"}) setting[field] = std::min(setting[field].get<uint32_t>(), *cap);
    }
    return schema;
}

}  // namespace heliograph

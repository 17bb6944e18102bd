#include "server/lab/accuracy/knobs.h"

#include <algorithm>

namespace heliograph {

namespace {

using enum KnobKind;

/// Glass makes two rays of one at every surface: with all limits at 31 and no threshold a path has 2^31 ends. With this one
/// what is estimated in place of rays can change a pixel by a twentieth of a display code at most, each.
constexpr float REFERENCE_THRESHOLD = 0.0002f;

constexpr std::string_view SHOWN = "it is what the picture shows, not how exactly";

const std::vector<Knob>& table() {
    static const std::vector<Knob> KNOBS = {
        {"renderScale", cut, {"0.25", "0.5", "0.75", "1"}, {}},
        {"automaticScale", viewer, {"on", "off"}, "while a viewer moves; renderScale shows what it costs"},
        {"samples", grain, {"1", "2", "4", "8", "16", "32", "64", "128", "256"}, {}},
        {"errorTarget", viewer, {"10", "1", "0"}, "while a view refines; samples shows what it costs"},
        {"adaptive", viewer, {"on", "off"}, "with errorTarget; bench adaptive shows what it costs"},
        {"integrator", light, {"interactive", "path"}, "path is exact but for what docs/reference/accuracy.md lists"},
        {"maxBounces", cut, {"1", "2", "4", "8", "16", "64", "255"}, {}},
        {"shadows", light, {"off", "on"}, {}},
        {"softShadows", light, {"off", "on"}, {}},
        {"shadowSamples", grain, {"1", "2", "4", "8", "16", "64"}, {}},
        {"manyLights", grain, {"on", "off"}, {}},
        {"lightRays", grain, {"1", "2", "4", "8", "16", "64"}, {}},
        {"reflections", light, {"off", "on"}, {}},
        {"maxReflections", cut, {"0", "1", "2", "4", "8", "31"}, {}},
        {"glossyReflections", light, {"off", "on"}, {}},
        {"refractions", light, {"off", "on"}, {}},
        {"maxRefractions", cut, {"0", "1", "2", "4", "8", "16", "31"}, {}},
        {"ambientOcclusion", light, {"off", "on"}, {}},
        {"aoSamples", grain, {"1", "4", "9", "25", "64"}, {}},
        {"aoRadius", look, {"0.1", "1"}, SHOWN},
        {"indirectLight", light, {"off", "on"}, {}},
        {"indirectBounces", cut, {"1", "2", "4", "8", "16"}, {}},
        {"surfaceLights", light, {"off", "on"}, {}},
        {"environmentLight", light, {"off", "on"}, {}},
        {"roughGlass", light, {"off", "on"}, {}},
        {"depthOfField", look, {"off", "on"}, SHOWN},
        {"motionBlur", look, {"off", "on"}, SHOWN},
        {"fog", look, {"off", "on"}, SHOWN},
        {"fogSamples", grain, {"1", "2", "4", "8", "16"}, {}},
        {"textureFilter", cut, {"trilinear", "anisotropic"}, {}},
        {"environment", light, {"off", "on"}, "off, its mean colour stands for the image"},
        {"contributionThreshold", cut, {"0.1", "0.03", "0.01", "0.004", "0.001", "0"}, {}},
        {"adaptiveQuality", viewer, {"on", "off"}, "on slow lines; renderScale and jpegQuality show what it costs"},
        {"codec", viewer, {"automatic", "jpeg"}, "on slow lines; bytes and PSNR of both: docs/measurements/feel.md"},
        {"denoiser", filter, {"filter", "off"}, {}},
        {"exactAtRest",
         viewer,
         {"off", "on"},
         "on, a picture at rest has no error of coding; jpegQuality shows that of others"},
        {"primaryPackets", neutral, {"off", "on"}, {}},
        {"secondaryPackets", neutral, {"off", "on"}, {}},
        {"bvhQuality", neutral, {"low", "medium", "high"}, {}},
        {"exactRounding", neutral, {"off", "on"}, "on processors it is always on"},
        {"robust", neutral, {"off", "on"}, {}},
        {"jpegQuality", display, {"10", "30", "50", "70", "80", "90", "95", "100"}, {}},
    };
    return KNOBS;
}

const EffectRow* effectNamed(std::string_view name) {
    for (const EffectRow& row : effectRows()) {
        if (row.name == name) return &row;
    }
    return nullptr;
}

/// The effect row that a setting belongs to, or "".
std::string effectOf(std::string_view setting) {
    for (const nlohmann::json& row : settingsSchema()) {
        if (row["name"] == setting) return row["effect"].get<std::string>();
    }
    return {};
}

}  // namespace

std::string_view word(KnobKind kind) {
    static constexpr std::string_view WORDS[] = {"grain", "cut", "light", "neutral", "display", "filter", "look", "viewer"};
    return WORDS[static_cast<size_t>(kind)];
}

std::span<const Knob> knobs() { return table(); }

Settings turned(Settings settings, const Knob& knob, std::string_view value) {
    settings.setFromText(std::string(knob.setting) + "=" + std::string(value));
    return settings;
}

std::string valueOf(const Settings& settings, const Knob& knob) {
    for (std::string_view value : knob.values) {
        if (turned(settings, knob, value) == settings) return std::string(value);
    }
    const nlohmann::json value = settings.toJson().at(std::string(knob.setting));
    return value.is_string() ? value.get<std::string>() : value.dump();
}

Settings mostExact(Settings settings) {
    for (const Knob& knob : knobs()) {
        const bool biased = knob.setting == "aoSamples" && settings.aoPower != 1.0f;
        if (knob.kind == cut || knob.kind == filter || biased) settings = turned(settings, knob, knob.exact());
    }
    settings.contributionThreshold = REFERENCE_THRESHOLD;
    settings.robust = true;
    return settings;
}

Settings allLight(Settings settings) {
    settings = mostExact(settings);
    for (const Knob& knob : knobs()) {
        if (knob.kind == light) settings = turned(settings, knob, knob.exact());
    }
    return settings;
}

std::optional<std::string> whyNot(const Knob& knob, const Settings& settings, const std::vector<EffectReason>& effects) {
    if (!knob.turned()) return std::string(knob.note);
    const std::string effect = effectOf(knob.setting);
    if (effect.empty()) return {};
    const auto reason = std::ranges::find(effects, effect, &EffectReason::name);
    if (reason != effects.end() && !reason->possible()) return "not called for: " + reason->because;
    if (knob.kind == light) {
        // A switch of what another one must allow first, as softShadows without shadows.
        const bool possible = allowedEffects(turned(settings, knob, knob.exact())).bits !=
                              allowedEffects(turned(settings, knob, knob.values.front())).bits;
        if (!possible) return "another setting has it off already";
        return {};
    }
    const EffectRow* row = effectNamed(effect);
    // A knob that switches its effect itself, as textureFilter does, is not kept from acting by being off.
    if (row && row->setting != knob.setting && !allowedEffects(settings).has(row->bit)) {
        return std::string(row->setting) + " is off in this view";
    }
    return {};
}

}  // namespace heliograph

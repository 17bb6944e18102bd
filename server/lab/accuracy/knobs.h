#pragma once
// What can be turned between fast and exact: an entry for each row of the settings table that has a price, and for some that
// shall have none. A row with a price and without an entry fails a test.

#include "server/request/effect_rules.h"
#include "server/request/settings.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

enum class KnobKind {
    grain,    // fewer rays, more noise; the mean of many samples does not depend on it
    cut,      // what is left out or estimated; the picture's mean depends on it
    light,    // a part of the transport of light, there or not
    neutral,  // must change nothing but time
    display,  // how the picture is coded
    filter,   // what is made of the film; its errors are of no one sign
    look,     // what is shown, not how well: never turned
    viewer,   // acts in a viewer's stream alone: never turned here
};
/// "grain", "cut", ...
std::string_view word(KnobKind kind);

struct Knob {
    std::string_view setting;
    KnobKind kind = KnobKind::look;
    std::vector<std::string_view> values;  // as for --set, from cheap to exact; the last one is the most exact
    std::string_view note;                 // why it is not turned, or what to know of it

    bool turned() const { return kind != KnobKind::look && kind != KnobKind::viewer; }
    std::string_view exact() const { return values.back(); }
};

/// In the settings table's order.
std::span<const Knob> knobs();

/// The settings with this value. Throws InputError if it is none.
Settings turned(Settings settings, const Knob& knob, std::string_view value);
/// The value that the settings have, spelled as `values` are where it is one of them.
std::string valueOf(const Settings& settings, const Knob& knob);

/// Every cut at its most exact value, but for a contributionThreshold of 0.0002 that keeps glass from endless rays: what the view
/// would be if nothing were left out of what its switches ask for. Grain is as given, but for occlusion rays with an aoPower other than 1, which the mean then depends on.
Settings mostExact(Settings settings);
/// Every part of the transport of light there, by the path integrator, without a cut.
Settings allLight(Settings settings);

/// Why turning the knob can change nothing here, for people; nothing where it can. `effects`: the scene's.
std::optional<std::string> whyNot(const Knob& knob, const Settings& settings, const std::vector<EffectReason>& effects);

}  // namespace heliograph

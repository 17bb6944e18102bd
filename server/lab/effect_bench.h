#pragma once
// What each effect costs in one view of a scene, with and without it; and the proof that what a scene does not call for
// costs nothing. Two requests are always rendered one right after the other, in changing order, and compared within that
// pair, so that a busy machine slows both alike.

#include "server/lab/device_bench.h"
#include "server/request/effect_pair.h"

namespace heliograph {

struct EffectBenchOptions {
    Settings settings;
    Camera camera;
    uvec2 resolution{1280, 720};
    uint32_t repetitions = 9;
};

/// Two things measured in turns: the same number of repetitions of each.
struct PairedTiming {
    Timing first, second;
};

/// Time of the first over time of the second, formed within each repetition.
struct PairedRatio {
    double median = 0.0;
    double low = 0.0;   // first quartile
    double high = 0.0;  // third quartile
};

/// Of processor time if `core`, else of wall time.
PairedRatio ratioOf(const PairedTiming& timing, bool core);

/// True for devices that are the processor itself: their processor time says more than wall time on a machine that does
/// other work too.
bool timedByCore(const Renderer& renderer, const Settings& settings);

struct EffectBenchResult {
    struct Row {
        EffectReason effect;
        PairedTiming time;  // first: on; second: off
    };
    std::string scene;
    std::string device;
    uvec2 resolution{0, 0};
    uint32_t repetitions = 0;
    bool core = false;                 // ratios are of processor time
    std::vector<std::string> effects;  // of the view under the settings as given
    std::vector<Row> rows;             // in the table's order
};

/// The device holds the scene already. One round before the first is not counted.
EffectBenchResult benchEffects(Renderer& renderer, const Scene& scene, const EffectBenchOptions& options,
                               const Progress& progress);

/// {scene, device, width, height, repetitions, time, effects, rows:[...]}: fields in docs/reference/benchmarks.md.
nlohmann::ordered_json toJson(const EffectBenchResult& result);

/// A view with every switch on (withAllAllowed) beside the same view with the needed ones alone (withOnlyCalledFor).
struct EffectCheckResult {
    std::string scene;
    std::string device;
    uvec2 resolution{0, 0};
    uint32_t repetitions = 0;
    bool core = false;
    double limit = 0.0;                    // how far from 1 the ratio may be
    std::vector<std::string> switchedOff;  // settings that are off in the second only
    std::vector<std::string> effects;      // of both
    PairedTiming time;                     // first: everything allowed; second: only what is called for
    PairedTiming noise;                    // the second beside itself: what the machine's unrest makes of equal requests
    uint64_t differingPixels = 0;          // most in any repetition; bit for bit
    bool identical() const { return differingPixels == 0; }
    bool within() const;
    bool passed() const { return identical() && within(); }
};

/// The device holds the scene already. One round before the first is not counted.
EffectCheckResult checkEffects(Renderer& renderer, const Scene& scene, const EffectBenchOptions& options, double limit,
                               const Progress& progress);

nlohmann::ordered_json toJson(const EffectCheckResult& result);

/// This build's frames beside those of another build of the program, or of another scene, in turns. Each is a process of its
/// own; both are started anew several times, since where memory comes to lie moves the times of all frames of a process.
struct EffectAgainstResult {
    std::string scene;
    std::string otherScene;
    std::string device;  // with details: which effects a build was made without
    std::string otherDevice;
    uvec2 resolution{0, 0};
    uint32_t repetitions = 0;
    uint32_t starts = 0;
    bool core = false;
    double limit = 0.0;
    std::vector<std::string> effects;  // of the view, in both
    PairedTiming time;                 // first: this build; second: the other
    bool identical = true;             // every frame, bit for bit
    bool sameScene() const { return scene == otherScene; }
    /// Beside another scene only being slower counts.
    bool within() const;
    bool passed() const { return (identical || !sameScene()) && within(); }
};

nlohmann::ordered_json toJson(const EffectAgainstResult& result);

}  // namespace heliograph

#pragma once
// What accuracy costs in a scene: each knob turned by itself from the settings as given, then combinations of them, each
// timed beside the settings as given and compared with references (reference.h). Method: docs/reference/benchmarks.md.

#include "server/film/film.h"
#include "server/lab/accuracy/knobs.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/effect_bench.h"
#include "server/request/setting_caps.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace heliograph {

struct AccuracyView {
    std::string name;
    Camera camera;
};

struct AccuracyOptions {
    Settings settings;  // as given: where every knob is turned from
    std::vector<AccuracyView> views;
    uvec2 resolution{320, 180};     // at a renderScale of 1
    double budgetSeconds = 120.0;   // of FrameMaker::seconds
    uint32_t repetitions = 5;       // timings of a point, at most
    uint32_t referenceSamples = 0;  // of each reference; 0: as the budget allows
    SettingCaps caps;               // `settings` keep to them; values beyond them are measured in references alone
};

/// Of all views together: root mean squares of errors, means of the rest, the worst `p99`.
struct PointError {
    LinearError own;       // against the view's own most exact settings
    LinearError light;     // against the path integrator
    DisplayError display;  // against that of `own`, or of `light` where the point is judged by it
};

/// One choice of settings, measured.
struct AccuracyPoint {
    std::vector<std::string> set;  // what differs from the settings as given, as for --set; empty: nothing
    Settings settings;
    bool coding = false;     // only display differs: `ms` is the time of coding, and its error that of coding
    bool byLight = false;    // judged by `light`: turns a part of the transport on that the view lacks
    PairedTiming time;       // first: this; second: the settings as given; mean of a view
    std::vector<double> ms;  // of coding
    uint64_t bytes = 0;      // of coding
    PointError error;
    bool measured = false;
    const LinearError& judged() const { return byLight ? error.light : error.own; }
};

struct AccuracyRow {
    std::string knob;  // a setting, or "combination"
    std::string value;
    bool exact = false;  // most exact of its knob
    bool given = false;  // as the settings have it
    size_t point = 0;
    /// `rmse` against the same knob's most exact value with the same samples, which leaves out what they have in common;
    /// negative: not known.
    double fromExact = -1.0;
};

struct NotTurned {
    std::string knob;
    std::string why;
};

/// Time of a point: what its frame would take beside the median frame of the settings as given.
struct PointTime {
    double ms = 0.0, low = 0.0, high = 0.0;  // median and quartiles
    size_t repetitions = 0;
};

class AccuracySweep {
public:
    /// Shares of the budget, each with those before: of references, and of rounds over all points.
    static constexpr double REFERENCES_UNTIL = 0.4, SWEEP_UNTIL = 0.75;

    /// Both outlive this.
    AccuracySweep(FrameMaker& frames, const Scene& scene, AccuracyOptions options);

    /// Called whenever something more is measured.
    void onStep(std::function<void()> step) { step_ = std::move(step); }
    /// References, rounds over all points, combinations: until the budget is spent, but each point once at least.
    void run(const Progress& progress);

    /// After `run`: measures these settings, too, as often as the others at most, whatever is left of the budget. Returns their row.
    size_t measure(const Settings& settings, const Progress& progress);

    const AccuracyOptions& options() const { return options_; }
    const std::vector<AccuracyPoint>& points() const { return points_; }
    const std::vector<AccuracyRow>& rows() const { return rows_; }
    const std::vector<NotTurned>& notTurned() const { return notTurned_; }
    const Reference& reference(size_t view, bool light) const { return light ? views_[view].light : views_[view].own; }
    /// Of all views: root mean square of their own errors.
    double referenceError(bool light) const;
    /// Error of the interactive integrator without a cut, against the path integrator: of the model itself.
    LinearError modelError() const;
    PointTime timeOf(const AccuracyPoint& point) const;
    bool timedByCore() const { return core_; }
    /// Radiance from which on every tone curve shows white, with the exposure of scene and settings: what is brighter is compared
    /// as that. Highlights of lamps without extent may be 10,000 times as bright, and would be all that an error tells of.
    float ceiling() const;
    const std::string& device() const { return device_; }
    /// Row indices of the front by time and `judged().rmse`, of rows that are judged by the view's own reference.
    std::vector<size_t> front() const;
    /// The front's row of the least error that takes no longer; nothing where none does.
    std::optional<size_t> bestWithin(double ms) const;
    /// The picture of a point in the first view, rendered once more.
    LinearPicture picture(const AccuracyPoint& point);
    DisplayImage shown(const LinearPicture& picture) const;
    const Scene& scene() const { return scene_; }

    /// What is measured, to be taken up again: points as JSON, references as bytes. `restore` is false, and nothing is taken,
    /// where the state is of another scene, view, size or settings.
    nlohmann::ordered_json state() const;
    std::vector<uint8_t> referenceBytes() const;
    bool restore(const nlohmann::json& state, std::span<const uint8_t> references);

private:
    struct View {
        Camera camera;
        Reference own, light;
        LinearPicture ownPicture, lightPicture;
        DisplayImage ownShown, lightShown;
    };

    PointTime timeOf(const AccuracyPoint& point, double givenMs) const;
    double givenMs() const;
    void makeRows();
    size_t pointOf(std::vector<std::string> set, const Settings& settings);
    void makeReferences(const Progress& progress);
    void finishReferences();
    void sweep(const Progress& progress);
    void sweepKnob(const Knob& knob, uint32_t round, const Progress& progress);
    void compare(AccuracyRow& row, const std::vector<LinearPicture>& pictures, const Knob& knob);
    void search(const Progress& progress);
    void timeOnce(AccuracyPoint& point);
    void timeCoding(AccuracyPoint& point);
    std::vector<LinearPicture> pictures(const Settings& settings);
    double frame(const Settings& settings, size_t view, Timing& timing, double& coreMs, LinearPicture& picture);
    void judge(AccuracyPoint& point, const std::vector<LinearPicture>& pictures);
    FrameRequest request(const Settings& settings, size_t view);
    LinearPicture compared(const LinearPicture& picture) const;
    uvec2 sizeFor(const Settings& settings) const;
    double spent() const { return spentBefore_ + frames_.seconds() - begin_; }
    bool over(double share) const { return spent() >= share * options_.budgetSeconds; }
    bool allowed(const Settings& settings) const { return capped(settings, options_.caps) == settings; }
    void say(const Progress& progress, const std::string& what) const;
    void step() const {
        if (step_) step_();
    }

    FrameMaker& frames_;
    const Scene& scene_;
    AccuracyOptions options_;
    std::string device_;
    bool core_ = false;
    std::vector<View> views_;
    std::vector<AccuracyPoint> points_;
    std::vector<AccuracyRow> rows_;
    std::vector<NotTurned> notTurned_;
    std::vector<LinearPicture> exact_;   // of the most exact value of the knob that is swept, or none
    std::vector<LinearPicture> given_;   // of the settings as given, or none yet
    std::vector<LinearPicture> latest_;  // of the point that was timed last
    Film film_;
    uint32_t generation_ = 0;
    double begin_ = 0.0;        // FrameMaker::seconds
    double spentBefore_ = 0.0;  // in runs that this one goes on from
    std::function<void()> step_;
};

}  // namespace heliograph

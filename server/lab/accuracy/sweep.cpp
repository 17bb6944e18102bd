#include "server/lab/accuracy/sweep.h"

#include "server/base/clock.h"
#include "server/encode/tone_map.h"
#include "server/lab/accuracy/coding.h"
#include "server/lab/accuracy/pareto.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

constexpr double LIGHT_SHARE = 0.4;  // of the references' time, for that of the path integrator

double rootMeanSquare(const std::vector<double>& values) {
    double sum = 0.0;
    for (double value : values) sum += value * value;
    return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

LinearError together(const std::vector<LinearError>& errors) {
    LinearError all;
    std::vector<double> rmse, rmseAll;
    for (const LinearError& error : errors) {
        rmse.push_back(error.rmse);
        rmseAll.push_back(error.rmseAll);
        all.relativeMse += error.relativeMse / static_cast<double>(errors.size());
        all.bias += error.bias / static_cast<double>(errors.size());
    }
    all.rmse = rootMeanSquare(rmse);
    all.rmseAll = rootMeanSquare(rmseAll);
    return all;
}

}  // namespace

AccuracySweep::AccuracySweep(FrameMaker& frames, const Scene& scene, AccuracyOptions options)
    : frames_(frames), scene_(scene), options_(std::move(options)), begin_(frames.seconds()) {
    device_ = frames_.infoFor(options_.settings).name;
    core_ = frames_.timedByCore(options_.settings);
    for (const AccuracyView& view : options_.views) {
        views_.push_back({view.camera, {}, {}, {}, {}, {}, {}});
        const size_t index = views_.size() - 1;
        views_[index].own = Reference(request(mostExact(options_.settings), index));
        views_[index].light = Reference(request(allLight(options_.settings), index));
    }
    makeRows();
}

uvec2 AccuracySweep::sizeFor(const Settings& settings) const {
    const vec2 scaled = glm::round(vec2(options_.resolution) * settings.renderScale);
    return glm::max(uvec2(scaled), uvec2(1));
}

FrameRequest AccuracySweep::request(const Settings& settings, size_t view) {
    return frameRequest(scene_, views_[view].camera, settings, sizeFor(settings), ++generation_);
}

void AccuracySweep::say(const Progress& progress, const std::string& what) const {
    const double left = options_.budgetSeconds - spent();
    const std::string rest = left > 0.0 ? "about " + std::to_string(std::lround(left)) + " s left"
                                        : "over the budget: every setting is measured once";
    report(progress, what + ", " + rest, spent() / options_.budgetSeconds);
}

size_t AccuracySweep::pointOf(std::vector<std::string> set, const Settings& settings) {
    const auto found = std::ranges::find(points_, settings, &AccuracyPoint::settings);
    if (found != points_.end()) return static_cast<size_t>(found - points_.begin());
    AccuracyPoint point;
    point.set = std::move(set);
    point.settings = settings;
    points_.push_back(std::move(point));
    return points_.size() - 1;
}

void AccuracySweep::makeRows() {
    const std::vector<EffectReason> effects = explainEffects(scene_);
    const EffectSet scene = possibleEffects(effects);
    pointOf({}, options_.settings);
    for (const Knob& knob : knobs()) {
        if (const std::optional<std::string> why = whyNot(knob, options_.settings, effects)) {
            notTurned_.push_back({std::string(knob.setting), *why});
            continue;
        }
        for (std::string_view value : knob.values) {
            const Settings settings = turned(options_.settings, knob, value);
            if (!allowed(settings)) continue;
            const std::string text = std::string(knob.setting) + "=" + std::string(value);
            const bool given = settings == options_.settings;
            const size_t index = pointOf({text}, settings);
            AccuracyPoint& point = points_[index];
            point.coding = knob.kind == KnobKind::display && !given;
            // What adds to the view's effects is nearer to the truth of light, and farther from the view as it is.
            const uint32_t before = allowedEffects(options_.settings).bits & scene.bits;
            const uint32_t now = allowedEffects(settings).bits & scene.bits;
            point.byLight = knob.kind == KnobKind::light && (now & ~before) != 0;
            rows_.push_back({std::string(knob.setting), std::string(value), value == knob.exact(), given, index});
        }
        if (knob.kind != KnobKind::display) continue;
        // The value as given is coded too: a point of its own, though nothing differs from the settings as given.
        for (AccuracyRow& row : rows_) {
            if (row.knob != knob.setting || !row.given) continue;
            AccuracyPoint point;
            point.set = {std::string(knob.setting) + "=" + row.value};
            point.settings = options_.settings;
            point.coding = true;
            row.point = points_.size();
            points_.push_back(std::move(point));
        }
    }
}

void AccuracySweep::makeReferences(const Progress& progress) {
    double ownSpent = 0.0, lightSpent = 0.0;
    auto enough = [&](const Reference& reference) {
        if (!reference.hasBothHalves() || reference.samples() % (2 * Reference::RUN) != 0) return false;
        return options_.referenceSamples > 0 ? reference.samples() >= options_.referenceSamples : over(REFERENCES_UNTIL);
    };
    auto all = [&](auto part) { return std::ranges::all_of(views_, [&](const View& v) { return enough(v.*part); }); };
    while (!all(&View::own) || !all(&View::light)) {
        bool light = ownSpent * LIGHT_SHARE > lightSpent * (1.0 - LIGHT_SHARE);
        if (all(&View::own)) light = true;
        else if (all(&View::light)) light = false;
        for (View& view : views_) {
            Reference& reference = light ? view.light : view.own;
            const double before = reference.seconds();
            if (!enough(reference)) reference.addRun(frames_);
            (light ? lightSpent : ownSpent) += reference.seconds() - before;
        }
        say(progress, light ? "reference of all light" : "reference");
        step();
    }
}

void AccuracySweep::finishReferences() {
    for (View& view : views_) {
        view.ownPicture = limited(view.own.picture(), ceiling());
        view.lightPicture = limited(view.light.picture(), ceiling());
        view.ownShown = shown(view.ownPicture);
        view.lightShown = shown(view.lightPicture);
    }
}

float AccuracySweep::ceiling() const { return whiteRadiance(scene_.exposure + options_.settings.exposure); }

LinearPicture AccuracySweep::compared(const LinearPicture& picture) const {
    return resized(limited(picture, ceiling()), options_.resolution);
}

DisplayImage AccuracySweep::shown(const LinearPicture& picture) const {
    DisplayImage image;
    const ToneCurve curve = shownCurve(static_cast<ToneCurve>(options_.settings.toneCurve), scene_.fromFile);
    const ToneMap toneMap(scene_.exposure + options_.settings.exposure, curve);
    toneMap.apply(picture.pixels, picture.resolution, image);
    return image;
}

double AccuracySweep::referenceError(bool light) const {
    std::vector<double> errors;
    for (const View& view : views_) {
        const Reference& reference = light ? view.light : view.own;
        if (reference.hasBothHalves()) errors.push_back(reference.ownError(ceiling()));
    }
    return rootMeanSquare(errors);
}

LinearError AccuracySweep::modelError() const {
    std::vector<LinearError> errors;
    for (const View& view : views_) errors.push_back(linearError(view.ownPicture, view.lightPicture));
    return together(errors);
}

/// Renders one picture and returns its wall milliseconds, with those of denoising.
double AccuracySweep::frame(const Settings& settings, size_t view, Timing& timing, double& coreMs, LinearPicture& picture) {
    const FrameRequest asked = request(settings, view);
    frames_.prepare(settings);  // trees of another quality are no part of a frame
    const double core = processCpuSeconds();
    const FrameStats stats = frames_.frame(asked, settings.samples, film_);
    coreMs = 1e3 * (processCpuSeconds() - core);
    timing.rays.add(stats.rays);
    picture.resolution = film_.resolution();
    const double before = processCpuSeconds();
    const double denoiseMs = frames_.picture(asked, film_, static_cast<double>(ceiling()), picture.pixels);
    if (denoiseMs > 0.0) coreMs += 1e3 * (processCpuSeconds() - before);
    return stats.milliseconds + denoiseMs;
}

/// One pair of the point and the settings as given, in changing order; `latest_` are the point's pictures then.
void AccuracySweep::timeOnce(AccuracyPoint& point) {
    const bool first = point.time.first.wallMs.size() % 2 == 0;
    point.time.first.rays = point.time.second.rays = {};
    latest_.clear();
    const auto count = static_cast<double>(views_.size());
    auto one = [&](bool own) {
        Timing& timing = own ? point.time.first : point.time.second;
        double wall = 0.0, core = 0.0;
        for (size_t view = 0; view < views_.size(); view++) {
            double coreMs = 0.0;
            LinearPicture picture;
            wall += frame(own ? point.settings : options_.settings, view, timing, coreMs, picture) / count;
            core += coreMs / count;
            if (own) latest_.push_back(std::move(picture));
        }
        timing.wallMs.push_back(wall);
        timing.coreMs.push_back(core);
    };
    one(first);
    one(!first);
}

void AccuracySweep::timeCoding(AccuracyPoint& point) {
    std::vector<DisplayError> errors;
    double ms = 0.0;
    point.bytes = 0;
    for (const View& view : views_) {
        const CodedPicture coded = codedAsJpeg(view.ownShown, point.settings.jpegQuality);
        ms += coded.ms / static_cast<double>(views_.size());
        point.bytes += coded.bytes / views_.size();
        errors.push_back(displayError(coded.image, view.ownShown));
    }
    point.ms.push_back(ms);
    point.error.display = {};
    for (const DisplayError& error : errors) {
        point.error.display.psnrDb += error.psnrDb / static_cast<double>(errors.size());
        point.error.display.flip += error.flip / static_cast<double>(errors.size());
        point.error.display.p99 = std::max(point.error.display.p99, error.p99);
    }
    point.measured = true;
}

void AccuracySweep::judge(AccuracyPoint& point, const std::vector<LinearPicture>& pictures) {
    std::vector<LinearError> own, light;
    DisplayError display;
    const auto count = static_cast<double>(views_.size());
    for (size_t i = 0; i < views_.size(); i++) {
        const LinearPicture full = compared(pictures[i]);
        own.push_back(linearError(full, views_[i].ownPicture));
        light.push_back(linearError(full, views_[i].lightPicture));
        const DisplayImage codes = resized(shown(pictures[i]), options_.resolution);
        const DisplayError error = displayError(codes, point.byLight ? views_[i].lightShown : views_[i].ownShown);
        display.psnrDb += error.psnrDb / count;
        display.flip += error.flip / count;
        display.p99 = std::max(display.p99, error.p99);
    }
    point.error = {together(own), together(light), display};
    point.measured = true;
}

std::vector<LinearPicture> AccuracySweep::pictures(const Settings& settings) {
    std::vector<LinearPicture> made;
    for (size_t view = 0; view < views_.size(); view++) {
        Timing timing;
        double coreMs = 0.0;
        frame(settings, view, timing, coreMs, made.emplace_back());
    }
    return made;
}

LinearPicture AccuracySweep::picture(const AccuracyPoint& point) {
    Timing timing;
    double coreMs = 0.0;
    LinearPicture made;
    frame(point.settings, 0, timing, coreMs, made);
    return resized(made, options_.resolution);
}

PointTime AccuracySweep::timeOf(const AccuracyPoint& point) const {
    if (point.coding) {
        return {median(point.ms), percentile(point.ms, 0.25), percentile(point.ms, 0.75), point.ms.size()};
    }
    return timeOf(point, givenMs());
}

PointTime AccuracySweep::timeOf(const AccuracyPoint& point, double givenMs) const {
    const PairedRatio ratio = ratioOf(point.time, core_);
    return {ratio.median * givenMs, ratio.low * givenMs, ratio.high * givenMs, point.time.first.wallMs.size()};
}

/// The settings as given were timed beside every point: their median is the best known time here.
double AccuracySweep::givenMs() const {
    std::vector<double> given;
    for (const AccuracyPoint& point : points_) {
        given.insert(given.end(), point.time.second.wallMs.begin(), point.time.second.wallMs.end());
    }
    return median(given);
}

std::vector<size_t> AccuracySweep::front() const {
    const double given = givenMs();
    std::vector<Bargain> bargains;
    std::vector<size_t> rows;
    std::vector<bool> seen(points_.size(), false);
    for (size_t i = 0; i < rows_.size(); i++) {
        const AccuracyPoint& point = points_[rows_[i].point];
        if (point.coding || point.byLight || !point.measured) continue;
        if (seen[rows_[i].point]) continue;
        seen[rows_[i].point] = true;
        rows.push_back(i);
        bargains.push_back({timeOf(point, given).ms, point.error.own.rmse});
    }
    std::vector<size_t> front;
    for (size_t i : paretoFront(bargains)) front.push_back(rows[i]);
    return front;
}

std::optional<size_t> AccuracySweep::bestWithin(double ms) const {
    std::optional<size_t> best;  // the front grows dearer and better
    for (size_t row : front()) {
        if (timeOf(points_[rows_[row].point]).ms <= ms) best = row;
    }
    return best;
}

void AccuracySweep::run(const Progress& progress) {
    begin_ = frames_.seconds();
    makeReferences(progress);
    finishReferences();
    sweep(progress);
    search(progress);
    spentBefore_ = spent();
    begin_ = frames_.seconds();
}

void AccuracySweep::sweep(const Progress& progress) {
    given_ = pictures(options_.settings);  // threads start, memory is touched
    for (uint32_t round = 0; round < options_.repetitions && (round == 0 || !over(SWEEP_UNTIL)); round++) {
        for (const Knob& knob : knobs()) sweepKnob(knob, round, progress);
    }
}

/// One round over the rows of a knob, the most exact first. Points that several rows have in common are timed once a round.
void AccuracySweep::sweepKnob(const Knob& knob, uint32_t round, const Progress& progress) {
    exact_.clear();
    for (size_t i = rows_.size(); i-- > 0;) {
        AccuracyRow& row = rows_[i];
        if (row.knob != knob.setting || (round > 0 && over(SWEEP_UNTIL))) continue;
        AccuracyPoint& point = points_[row.point];
        const size_t times = point.coding ? point.ms.size() : point.time.first.wallMs.size();
        if (point.coding) {
            if (times <= round) timeCoding(point);
        } else {
            latest_.clear();
            if (times <= round) timeOnce(point);
            if (!point.measured) judge(point, latest_);
            if (row.given && !latest_.empty()) given_ = latest_;
            if (row.exact) exact_ = latest_;
            if (row.fromExact < 0.0) compare(row, row.given ? given_ : latest_, knob);
        }
        say(progress, row.knob + "=" + row.value);
        step();
    }
}

/// Pictures that are not at hand, since an earlier run has them timed, are rendered once more. Beyond the caps nothing is known.
void AccuracySweep::compare(AccuracyRow& row, const std::vector<LinearPicture>& pictures, const Knob& knob) {
    if (row.exact) {
        row.fromExact = 0.0;
        return;
    }
    const Settings exact = turned(options_.settings, knob, knob.exact());
    if (!allowed(exact)) return;
    const std::vector<LinearPicture> own = pictures.empty() ? this->pictures(points_[row.point].settings) : pictures;
    if (row.given) given_ = own;
    if (exact_.empty()) exact_ = this->pictures(exact);
    std::vector<double> apart;
    for (size_t view = 0; view < views_.size(); view++) {
        apart.push_back(linearError(compared(own[view]), compared(exact_[view])).rmse);
    }
    row.fromExact = rootMeanSquare(apart);
}

}  // namespace heliograph

#include "server/lab/live/adaptive_check.h"

#include "server/base/clock.h"
#include "server/film/adaptive_plan.h"
#include "server/film/error_model.h"
#include "server/lab/live/truth.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>

namespace heliograph {

namespace {

constexpr uint32_t GROWTH = 16;  // errors are asked for where samples have grown by a part of so many, as for a viewer

/// A film that grows pass by pass, with what it costs.
class GrowingFilm {
public:
    GrowingFilm(Renderer& renderer, const FrameRequest& request, const AdaptiveBounds& bounds)
        : renderer_(renderer), request_(request), bounds_(bounds) {
        film_.reset(request.resolution, request.generation);
        film_.setWhite(bounds.white);
        cell_ = glm::min(tileSize(request.settings), glm::min(request.resolution, uvec2(CELL_SIZE)));
    }

    /// A pass over all cells, or those of the plan.
    void addPass(const std::vector<bool>* cells) {
        const StopWatch watch;
        std::mutex mutex;
        auto sink = [&](TileResult&& result) {
            const StopWatch adding;
            film_.add(result);
            const double seconds = adding.seconds();
            std::lock_guard lock(mutex);
            now_.addingSeconds += seconds;
            now_.coreSeconds += result.seconds;
            now_.rays += result.rays.total();
        };
        view_.costs.begin(request_.resolution, cell_);
        const std::vector<Tile> tiles =
            cells ? film_.tilesFor(*cells, cell_) : film_.tilesFor(film_.completedSamples(), 1, cell_);
        if (film_.mostSamples() == 1) film_.makeRoomForSums();
        renderer_.render(request_, tiles, view_, sink, {});
        view_.costs.end();
        now_.seconds += watch.seconds();
    }

    /// As a viewer's picture that has samples everywhere: whether it is still above the target.
    bool uniformGoesOn() {
        const uint32_t samples = film_.completedSamples();
        if (samples >= 2 && samples >= askedAt_ + askedAt_ / GROWTH + 1) {
            const StopWatch watch;
            now_.estimated = film_.relativeError();
            askedAt_ = samples;
            now_.decidingSeconds += watch.seconds();
            now_.seconds += watch.seconds();
        }
        return samples < bounds_.samples && !(now_.estimated > 0.0 && now_.estimated <= bounds_.target);
    }

    /// The same of one with samples by need.
    bool adaptiveGoesOn() {
        const StopWatch watch;
        if (plan_.follow(film_, view_.costs, {bounds_.target, bounds_.samples})) now_.estimated = film_.relativeError();
        now_.decidingSeconds += watch.seconds();
        now_.seconds += watch.seconds();
        const bool reached = now_.estimated > 0.0 && now_.estimated <= bounds_.target;
        return !reached && !plan_.finished() && film_.completedSamples() < bounds_.samples;
    }
    const AdaptivePlan& plan() const { return plan_; }
    uint32_t samples() const { return film_.completedSamples(); }
    double estimated() const { return now_.estimated; }

    AdaptivePicture measured(const Truth& truth) const {
        AdaptivePicture picture = now_;
        std::vector<vec4> developed;
        film_.develop(developed);
        double sum = 0.0, deciding = 0.0, others = 0.0, decidingTruth = 0.0, othersTruth = 0.0;
        const std::vector<double> pixels = luminances(developed, truth.white);
        for (uint32_t y = 0; y < request_.resolution.y; y++) {
            for (uint32_t x = 0; x < request_.resolution.x; x++) {
                const size_t i = static_cast<size_t>(y) * request_.resolution.x + x;
                const bool decides = x % ErrorHistory::STEP == y * 5 % ErrorHistory::STEP;
                (decides ? deciding : others) += pixels[i];
                (decides ? decidingTruth : othersTruth) += truth.pixels[i];
                sum += static_cast<double>(developed[i].w);
            }
        }
        picture.samples = sum / static_cast<double>(pixels.size());
        picture.measured = truth.errorOf(pixels);
        picture.biasOfDeciding = deciding / decidingTruth - 1.0;
        picture.biasOfOthers = others / othersTruth - 1.0;
        return picture;
    }

    /// Says what no choice of samples goes below.
    void tellLeast(const Truth& truth, AdaptiveView& view) const {
        const uint32_t samples = film_.completedSamples();
        const double edges = film_.edgeShare();
        const double power = std::log2(errorDecay(samples, edges) / errorDecay(2.0 * samples, edges));
        const std::vector<double> costs = cellCosts();
        std::vector<CellError> told = film_.errorParts(), measured = measuredParts(truth), pixels;
        if (told.size() != costs.size()) return;  // black
        std::vector<vec4> developed(truth.pixels.size());
        film_.developWithVariance(0, request_.resolution.y, edges, developed.data());
        for (size_t cell = 0; cell < costs.size(); cell++) told[cell].cost = measured[cell].cost = costs[cell];
        for (size_t i = 0; i < developed.size(); i++) {
            const uvec2 place(i % request_.resolution.x, i / request_.resolution.x);
            const double square = luminanceOf(vec3(developed[i])) > truth.white ? 0.0 : static_cast<double>(developed[i].w);
            pixels.push_back({square, samples, costs[cellOf(place)] / pixelsOf(cellOf(place))});
        }
        view.leastTold = leastCost(told, power);
        view.leastMeasured = leastCost(measured, power);
        view.leastByPixels = leastCost(pixels, power);
    }

private:
    size_t cellOf(uvec2 pixel) const {
        return static_cast<size_t>(pixel.y / CELL_SIZE) * film_.cellCount().x + pixel.x / CELL_SIZE;
    }
    double pixelsOf(size_t cell) const {
        const uvec2 first = uvec2(cell % film_.cellCount().x, cell / film_.cellCount().x) * CELL_SIZE;
        const uvec2 size = glm::min(first + CELL_SIZE, request_.resolution) - first;
        return static_cast<double>(size.x) * size.y;
    }
    /// Of a sample of each cell.
    std::vector<double> cellCosts() const {
        std::vector<double> costs;
        for (size_t cell = 0; cell < static_cast<size_t>(film_.cellCount().x) * film_.cellCount().y; cell++) {
            const bool known = view_.costs.cells() == film_.cellCount();
            costs.push_back(known ? std::max(1.0, static_cast<double>(view_.costs.predicted(static_cast<uint32_t>(cell))))
                                  : pixelsOf(cell));
        }
        return costs;
    }
    /// Squared errors against the truth, by cell, without what the truth's own error makes of them and without the worst thousandth.
    std::vector<CellError> measuredParts(const Truth& truth) const {
        std::vector<vec4> developed;
        film_.develop(developed);
        const std::vector<double> pixels = luminances(developed, truth.white);
        std::vector<double> squares;
        for (size_t i = 0; i < pixels.size(); i++)
            squares.push_back((pixels[i] - truth.pixels[i]) * (pixels[i] - truth.pixels[i]));
        std::vector<double> ordered = squares;
        const auto worst = ordered.end() - 1 - static_cast<ptrdiff_t>(1e-3 * static_cast<double>(ordered.size()));
        std::nth_element(ordered.begin(), worst, ordered.end());
        std::vector<CellError> parts(static_cast<size_t>(film_.cellCount().x) * film_.cellCount().y);
        for (size_t i = 0; i < squares.size(); i++) {
            const uvec2 place(i % request_.resolution.x, i / request_.resolution.x);
            if (squares[i] <= *worst) parts[cellOf(place)].square += squares[i] - truth.ownSquare;
        }
        for (CellError& part : parts) part.square = std::max(0.0, part.square);
        return parts;
    }

    Renderer& renderer_;
    FrameRequest request_;
    AdaptiveBounds bounds_;
    Film film_;
    ViewMemory view_;
    AdaptivePlan plan_;
    uvec2 cell_{0, 0};
    AdaptivePicture now_;
    uint32_t askedAt_ = 0;
};

/// Between two states of a growing picture, where its measured error is `error`; errors fall as powers of time.
AdaptivePicture between(const AdaptivePicture& before, const AdaptivePicture& after, double error) {
    AdaptivePicture picture = after;
    if (!(before.measured > after.measured) || !(before.seconds > 0.0)) return picture;
    const double share = std::clamp(std::log(before.measured / error) / std::log(before.measured / after.measured), 0.0, 1.0);
    auto mix = [&](double a, double b) { return a * std::pow(b / a, share); };
    picture.samples = mix(before.samples, after.samples);
    picture.rays = static_cast<uint64_t>(mix(static_cast<double>(before.rays), static_cast<double>(after.rays)));
    picture.seconds = mix(before.seconds, after.seconds);
    picture.coreSeconds = mix(before.coreSeconds, after.coreSeconds);
    picture.measured = error;
    return picture;
}

nlohmann::ordered_json toJson(const AdaptivePicture& picture) {
    return {{"samples", picture.samples},
            {"rays", picture.rays},
            {"seconds", picture.seconds},
            {"core_seconds", picture.coreSeconds},
            {"deciding_seconds", picture.decidingSeconds},
            {"adding_seconds", picture.addingSeconds},
            {"estimated", picture.estimated},
            {"measured", picture.measured},
            {"bias_of_deciding", picture.biasOfDeciding},
            {"bias_of_others", picture.biasOfOthers}};
}

std::string line(const AdaptiveView& view, const char* what, const AdaptivePicture& picture) {
    char text[256];
    std::snprintf(text, sizeof text, "%-30s %-9s %7.1f %8.2f s %9.1f Mrays %7.3f%% %7.3f%%  %+.4f%% %+.4f%%\n",
                  (view.scene + ", " + view.view).substr(0, 30).c_str(), what, picture.samples, picture.seconds,
                  1e-6 * static_cast<double>(picture.rays), 100.0 * picture.estimated, 100.0 * picture.measured,
                  100.0 * picture.biasOfDeciding, 100.0 * picture.biasOfOthers);
    return text;
}

}  // namespace

double leastCost(std::span<const CellError> parts, double power) {
    double best = 0.0, costs = 0.0, squares = 0.0;
    for (const CellError& part : parts) {
        best += std::pow(std::pow(part.cost, power) * part.square, 1.0 / (power + 1.0));
        costs += part.cost;
        squares += part.square;
    }
    return squares > 0.0 ? std::pow(best, (power + 1.0) / power) / (costs * std::pow(squares, 1.0 / power)) : 1.0;
}

AdaptiveView checkAdaptive(Renderer& renderer, const FrameRequest& request, const AdaptiveBounds& bounds,
                           const Progress& progress) {
    RendererFrames frames(renderer);
    Reference reference(request);
    while (reference.samples() < bounds.referenceSamples) {
        reference.addRun(frames);
        report(progress, "reference", static_cast<double>(reference.samples()) / bounds.referenceSamples);
    }
    const Truth truth(reference, bounds.white);
    AdaptiveView view;
    view.referenceError = truth.ownError();
    GrowingFilm adaptive(renderer, request, bounds);
    while (adaptive.adaptiveGoesOn()) {
        adaptive.addPass(adaptive.plan().cells());
        report(progress, "adaptive", static_cast<double>(adaptive.samples()) / bounds.samples);
    }
    view.adaptive = adaptive.measured(truth);
    view.reached = adaptive.estimated() <= bounds.target;

    // On, past the target, until the error is as small as that one's; up to twice the samples.
    GrowingFilm uniform(renderer, request, bounds);
    bool above = true;
    AdaptivePicture before;
    for (uint32_t next = 2; view.equal.samples == 0.0 || above;) {
        uniform.addPass(nullptr);
        report(progress, "uniform", static_cast<double>(uniform.samples()) / bounds.samples);
        if (above && !(above = uniform.uniformGoesOn())) {
            view.uniform = uniform.measured(truth);
            uniform.tellLeast(truth, view);
        }
        if (uniform.samples() < next) continue;
        next += next / GROWTH + 1;
        const AdaptivePicture now = uniform.measured(truth);
        const bool ends = now.measured <= view.adaptive.measured || uniform.samples() >= 2 * bounds.samples;
        if (ends && view.equal.samples == 0.0) view.equal = between(before, now, view.adaptive.measured);
        before = now;
    }
    return view;
}

nlohmann::ordered_json toJson(const std::vector<AdaptiveView>& views) {
    nlohmann::ordered_json json;
    json["views"] = nlohmann::ordered_json::array();
    for (const AdaptiveView& view : views) {
        json["views"].push_back(
            {{"scene", view.scene},
             {"view", view.view},
             {"reference_error", view.referenceError},
             {"reached", view.reached},
             {"time_ratio", view.timeRatio()},
             {"ray_ratio", view.rayRatio()},
             {"least", {{"told", view.leastTold}, {"measured", view.leastMeasured}, {"by_pixels", view.leastByPixels}}},
             {"uniform", toJson(view.uniform)},
             {"adaptive", toJson(view.adaptive)},
             {"equal", toJson(view.equal)}});
    }
    return json;
}

std::string toTable(const std::vector<AdaptiveView>& views) {
    std::string table =
        "scene, view                    picture   samples     time         rays   estimated measured  bias: 1 in 16, others\n";
    char text[256];
    for (const AdaptiveView& view : views) {
        table +=
            line(view, "uniform", view.uniform) + line(view, "adaptive", view.adaptive) + line(view, "as good", view.equal);
        std::snprintf(text, sizeof text,
                      "  adaptive over uniform of the same measured error: %.2f of the time, %.2f of the rays%s\n",
                      view.timeRatio(), view.rayRatio(), view.reached ? "" : "; the target was not reached");
        table += text;
        std::snprintf(text, sizeof text,
                      "  the best choice of samples takes %.2f of the time by what cells tell, %.2f by what was measured of "
                      "them, %.2f by what pixels tell\n",
                      view.leastTold, view.leastMeasured, view.leastByPixels);
        table += text;
        const double adding = view.uniform.coreSeconds + view.uniform.addingSeconds;
        std::snprintf(text, sizeof text,
                      "  deciding takes %.2f %% of the time (uniform: %.2f %%), all of adding to the film %.2f %%; the "
                      "reference's own error is %.3f %%\n",
                      100.0 * view.adaptive.decidingSeconds / view.adaptive.seconds,
                      100.0 * view.uniform.decidingSeconds / view.uniform.seconds, 100.0 * view.uniform.addingSeconds / adding,
                      100.0 * view.referenceError);
        table += text;
    }
    return table;
}

}  // namespace heliograph

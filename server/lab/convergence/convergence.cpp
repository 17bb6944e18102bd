#include "server/lab/convergence/convergence.h"

#include "server/base/clock.h"
#include "server/lab/accuracy/reference.h"
#include "server/lab/convergence/means.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace heliograph {

namespace {

constexpr uint32_t VARIATION_SAMPLES = 64;  // by which pixels are sorted into smooth ones and others

using Sums = std::vector<glm::dvec3>;

/// Mean squared difference of the pixels that `of` picks, per channel.
double meanSquare(const LinearPicture& a, const LinearPicture& b, const std::vector<bool>& of) {
    double sum = 0.0, count = 0.0;
    for (size_t i = 0; i < a.pixels.size(); i++) {
        if (!of[i]) continue;
        const glm::dvec3 difference = glm::dvec3(vec3(a.pixels[i])) - glm::dvec3(vec3(b.pixels[i]));
        sum += glm::dot(difference, difference);
        count += 3.0;
    }
    return count > 0.0 ? sum / count : 0.0;
}

/// What rows are judged by.
struct HalvedTruth {
    LinearPicture picture, halves[2];
    std::vector<bool> all, smooth;
    double mean = 1.0;

    HalvedTruth(const Reference& reference, const Sums& variances)
        : picture(reference.picture()), halves{reference.half(0), reference.half(1)} {
        mean = levelOf(picture);
        all.assign(picture.pixels.size(), true);
        std::vector<double> variation;
        for (const glm::dvec3& v : variances) variation.push_back(v.x + v.y + v.z);
        std::vector<double> sorted = variation;
        std::nth_element(sorted.begin(), sorted.begin() + static_cast<ptrdiff_t>(sorted.size() / 2), sorted.end());
        for (const double v : variation) smooth.push_back(v <= sorted[sorted.size() / 2]);
    }

    /// The halves are twice as far from each other as their mean is from the truth.
    double ownSquare(const std::vector<bool>& of) const { return meanSquare(halves[0], halves[1], of) / 4.0; }
    double error(const LinearPicture& of, const std::vector<bool>& pixels) const {
        return std::sqrt(std::max(meanSquare(of, picture, pixels) - ownSquare(pixels), 0.0)) / mean;
    }
};

/// Variance of each pixel's samples, from another stretch of them.
Sums variancesOf(Renderer& renderer, FrameRequest request) {
    Sums sum(static_cast<size_t>(request.resolution.x) * request.resolution.y), squares = sum;
    for (uint32_t i = 0; i < VARIATION_SAMPLES; i++) {
        const Sums one = renderSamples(renderer, request, (1u << 23) + i, 1);
        for (size_t p = 0; p < one.size(); p++) {
            sum[p] += one[p];
            squares[p] += one[p] * one[p];
        }
    }
    for (size_t p = 0; p < sum.size(); p++) {
        const glm::dvec3 mean = sum[p] / double(VARIATION_SAMPLES);
        squares[p] = squares[p] / double(VARIATION_SAMPLES) - mean * mean;
    }
    return squares;
}

std::string line(const char* format, auto... values) {
    char text[256];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

}  // namespace

std::optional<ConvergenceView::Cost> ConvergenceView::cost() const {
    if (!rows.empty() && rows.front().error <= target) return Cost{double(rows.front().samples), rows.front().coreSeconds};
    for (size_t i = 1; i < rows.size(); i++) {
        const ConvergenceRow &a = rows[i - 1], &b = rows[i];
        if (b.error > target) continue;
        const double t = b.error > 0.0 ? std::log(a.error / target) / std::log(a.error / b.error) : 1.0;
        return Cost{a.samples * std::pow(double(b.samples) / a.samples, t),
                    a.coreSeconds * std::pow(b.coreSeconds / a.coreSeconds, t)};
    }
    return {};
}

std::optional<double> ConvergenceView::slope(uint32_t first, double ConvergenceRow::*error) const {
    double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (const ConvergenceRow& row : rows) {
        if (row.samples < first || !(row.*error > referenceError)) continue;
        const double x = std::log(double(row.samples)), y = std::log(row.*error);
        n += 1.0;
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
    }
    if (n < 2.0) return {};
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

ConvergenceView measureConvergence(Renderer& renderer, const FrameRequest& request, const ConvergenceBounds& bounds,
                                   const Progress& progress) {
    const double all = double(bounds.samples) + bounds.referenceSamples;
    RendererFrames frames(renderer);
    Reference reference(request);
    while (reference.samples() < bounds.referenceSamples) {
        reference.addRun(frames);
        report(progress, "reference", reference.samples() / all);
    }
    const HalvedTruth truth(reference, variancesOf(renderer, request));
    ConvergenceView view;
    view.referenceSamples = reference.samples();
    view.referenceError = std::sqrt(truth.ownSquare(truth.all)) / truth.mean;
    view.target = bounds.target;
    Sums sums(truth.picture.pixels.size());
    double core = 0.0, seconds = 0.0;
    for (uint32_t samples = 0; samples < bounds.samples;) {
        const uint32_t more = std::min(samples == 0 ? 1u : std::min(samples, Reference::RUN), bounds.samples - samples);
        const double before = processCpuSeconds();
        const StopWatch watch;
        const Sums added = renderSamples(renderer, request, samples, more);
        seconds += watch.seconds();
        core += processCpuSeconds() - before;
        for (size_t i = 0; i < sums.size(); i++) sums[i] += added[i];
        samples += more;
        report(progress, "picture", (bounds.referenceSamples + samples) / all);
        if (!std::has_single_bit(samples)) continue;
        const LinearPicture picture = meanPicture(sums, request.resolution, samples);
        view.rows.push_back({samples, core, seconds, truth.error(picture, truth.all), truth.error(picture, truth.smooth)});
    }
    return view;
}

nlohmann::ordered_json toJson(const std::vector<ConvergenceView>& views) {
    nlohmann::ordered_json json;
    json["views"] = nlohmann::ordered_json::array();
    for (const ConvergenceView& view : views) {
        nlohmann::ordered_json rows = nlohmann::ordered_json::array();
        for (const ConvergenceRow& row : view.rows)
            rows.push_back({{"samples", row.samples},
                            {"core_s", row.coreSeconds},
                            {"s", row.seconds},
                            {"error", row.error},
                            {"smooth_error", row.smoothError}});
        nlohmann::ordered_json one = {{"scene", view.scene},
                                      {"view", view.view},
                                      {"reference_samples", view.referenceSamples},
                                      {"reference_error", view.referenceError},
                                      {"target", view.target},
                                      {"rows", rows}};
        const auto cost = view.cost();
        one["samples_to_target"] = cost ? nlohmann::ordered_json(cost->samples) : nlohmann::ordered_json();
        one["core_s_to_target"] = cost ? nlohmann::ordered_json(cost->coreSeconds) : nlohmann::ordered_json();
        const auto slope = view.slope(1, &ConvergenceRow::error);
        one["slope"] = slope ? nlohmann::ordered_json(*slope) : nlohmann::ordered_json();
        json["views"].push_back(one);
    }
    return json;
}

std::string toTable(const std::vector<ConvergenceView>& views) {
    std::string table;
    for (const ConvergenceView& view : views) {
        table += view.scene + ", " + view.view +
                 line(": reference of %u samples, own error %.4f %%\n samples     core s     error    smooth\n",
                      view.referenceSamples, 100.0 * view.referenceError);
        for (const ConvergenceRow& row : view.rows)
            table +=
                line("%8u %10.3f %8.4f%% %8.4f%%\n", row.samples, row.coreSeconds, 100.0 * row.error, 100.0 * row.smoothError);
        for (const uint32_t from : {1u, 256u, 4096u}) {
            const auto all = view.slope(from, &ConvergenceRow::error), smooth = view.slope(from, &ConvergenceRow::smoothError);
            if (all && smooth) table += line("slope from %u samples on: %.2f, smooth %.2f\n", from, *all, *smooth);
        }
    }
    const auto first = views.empty() ? std::nullopt : views.front().cost();
    for (const ConvergenceView& view : views) {
        table += line("to %.3g %%: ", 100.0 * view.target) + view.scene + ", " + view.view;
        const auto cost = view.cost();
        table += cost ? line(": %.1f samples, %.3f core s", cost->samples, cost->coreSeconds) : ": not reached";
        if (cost && first) table += line(", %.2f of the first", cost->coreSeconds / first->coreSeconds);
        table += "\n";
    }
    return table;
}

}  // namespace heliograph

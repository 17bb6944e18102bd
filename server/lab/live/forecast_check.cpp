#include "server/lab/live/forecast_check.h"

#include "server/film/error_model.h"
#include "server/film/film.h"
#include "server/lab/live/truth.h"
#include "server/pace/error_forecast.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <mutex>

namespace heliograph {

namespace {

/// A film, and beside it the squares of its samples.
class CheckedFilm {
public:
    CheckedFilm(Renderer& renderer, const FrameRequest& request, double white) : renderer_(renderer), request_(request) {
        film_.reset(request.resolution, request.generation);
        film_.setWhite(white);
        squares_.assign(static_cast<size_t>(request.resolution.x) * request.resolution.y, 0.0);
        cell_ = glm::min(tileSize(request.settings), request.resolution);
        view_.costs.begin(request.resolution, cell_);
    }

    void addSample() {
        std::mutex mutex;
        auto sink = [&](TileResult&& result) {
            std::lock_guard lock(mutex);
            film_.add(result);
            const uvec2 origin = result.tile.origin, size = result.tile.size;
            const std::span<const vec4> sums = result.sums();
            for (uint32_t y = 0; y < size.y; y++) {
                for (uint32_t x = 0; x < size.x; x++) {
                    squares_[static_cast<size_t>(origin.y + y) * request_.resolution.x + origin.x + x] +=
                        static_cast<double>(sums[static_cast<size_t>(y) * size.x + x].w);
                }
            }
        };
        renderer_.render(request_, film_.tilesFor(samples_++, 1, cell_), view_, sink, {});
    }

    ForecastRow row(const Truth& truth) const {
        ForecastRow row;
        row.samples = samples_;
        row.estimated = film_.relativeError();
        row.edgeShare = film_.edgeShare();
        std::vector<vec4> developed;
        film_.develop(developed);
        const std::vector<double> pixels = luminances(developed, truth.white);
        std::vector<double> deviations, none(pixels.size(), 0.0);
        for (size_t i = 0; i < pixels.size(); i++) {
            const double mean = luminanceOf(vec3(developed[i]));
            deviations.push_back(std::sqrt(std::max(0.0, squares_[i] / samples_ - mean * mean) / (samples_ - 1.0)));
        }
        row.independent = std::sqrt(meanSquare(deviations, none)) / truth.mean;
        row.measured = truth.errorOf(pixels);
        row.ownError = truth.ownError();
        return row;
    }

    uint32_t samples() const { return samples_; }
    double relativeError() const { return film_.relativeError(); }
    double edgeShare() const { return film_.edgeShare(); }

private:
    Renderer& renderer_;
    FrameRequest request_;
    Film film_;
    std::vector<double> squares_;
    uvec2 cell_{0, 0};
    ViewMemory view_;
    uint32_t samples_ = 0;
};

/// What is said of all rows together.
struct Within {
    size_t rows = 0, within = 0;

    void add(double ratio) {
        rows++;
        if (ratio >= LEAST_RATIO && ratio <= MOST_RATIO) within++;
    }
    double share() const { return rows > 0 ? static_cast<double>(within) / static_cast<double>(rows) : 0.0; }
};

struct Summary {
    Within estimated, foretold, independent;
    size_t views = 0, viewsWithin = 0;  // with a forecast that counts; of them: all of whose forecasts are within

    explicit Summary(const std::vector<ForecastView>& all) {
        for (const ForecastView& view : all) {
            const Within before = foretold;
            for (const ForecastRow& row : view.rows) {
                if (row.samples < FORETOLD_FROM || !row.counts()) continue;
                estimated.add(row.ratio());
                independent.add(row.independent / row.measured);
                if (row.samples > FORETOLD_FROM) foretold.add(row.foretoldRatio());
            }
            const size_t rows = foretold.rows - before.rows;
            views += rows > 0;
            viewsWithin += rows > 0 && foretold.within - before.within == rows;
        }
    }
};

}  // namespace

ForecastView checkForecast(Renderer& renderer, const FrameRequest& request, const ForecastBounds& bounds,
                           const Progress& progress) {
    constexpr uint32_t LEAST_TO_STOP = 4;  // samples
    const double all = bounds.samples + bounds.referenceSamples;
    RendererFrames frames(renderer);
    Reference reference(request);
    while (reference.samples() < bounds.referenceSamples) {
        reference.addRun(frames);
        report(progress, "reference", reference.samples() / all);
    }
    const Truth truth(reference, bounds.white);
    CheckedFilm film(renderer, request, bounds.white);
    std::vector<ErrorPoint> history;
    ErrorLaw law;
    ForecastView view;
    while (film.samples() < bounds.samples) {
        film.addSample();
        const double error = film.relativeError();
        if (!view.stopped && film.samples() >= LEAST_TO_STOP && error <= bounds.target) view.stopped = film.row(truth);
        if (film.samples() <= FORETOLD_FROM) {
            history.push_back({film.samples(), 0.0, error});
            law = [edges = film.edgeShare()](double n) { return std::sqrt(errorDecay(n, edges)); };
        }
        if (film.samples() < 2 || !std::has_single_bit(film.samples())) continue;
        view.rows.push_back(film.row(truth));
        view.rows.back().foretold = forecastError(history, law).errorAt(film.samples());
        report(progress, "picture", (bounds.referenceSamples + film.samples()) / all);
    }
    return view;
}

double foretoldShare(const std::vector<ForecastView>& views) { return Summary(views).foretold.share(); }

nlohmann::ordered_json toJson(const std::vector<ForecastView>& views) {
    nlohmann::ordered_json json;
    json["views"] = nlohmann::ordered_json::array();
    for (const ForecastView& view : views) {
        nlohmann::ordered_json rows = nlohmann::ordered_json::array();
        for (const ForecastRow& row : view.rows) {
            rows.push_back({{"samples", row.samples},
                            {"estimated", row.estimated},
                            {"independent", row.independent},
                            {"foretold", row.foretold},
                            {"measured", row.measured},
                            {"reference_error", row.ownError},
                            {"edge_share", row.edgeShare},
                            {"counts", row.counts()}});
        }
        nlohmann::ordered_json stopped;
        if (view.stopped) {
            stopped = {{"samples", view.stopped->samples},
                       {"estimated", view.stopped->estimated},
                       {"measured", view.stopped->measured}};
        }
        json["views"].push_back({{"scene", view.scene}, {"view", view.view}, {"stopped", stopped}, {"rows", rows}});
    }
    const Summary summary(views);
    json["least_ratio"] = LEAST_RATIO;
    json["most_ratio"] = MOST_RATIO;
    json["from_samples"] = FORETOLD_FROM;
    auto add = [&](const char* name, const Within& within) {
        json[name] = {{"rows", within.rows}, {"within", within.within}, {"share", within.share()}};
    };
    add("estimated", summary.estimated);
    add("foretold", summary.foretold);
    add("independent", summary.independent);
    json["views_that_count"] = summary.views;
    json["views_within"] = summary.viewsWithin;
    return json;
}

std::string toTable(const std::vector<ForecastView>& views) {
    std::string table =
        "scene, view                     samples  measured estimated ratio  foretold ratio  independent  edges\n";
    char line[256];
    for (const ForecastView& view : views) {
        for (const ForecastRow& row : view.rows) {
            std::snprintf(line, sizeof line, "%-32s %6u %8.3f%% %8.3f%%  %.2f %8.3f%%  %.2f        %.2f   %.2f%s\n",
                          (view.scene + ", " + view.view).substr(0, 32).c_str(), row.samples, 100.0 * row.measured,
                          100.0 * row.estimated, row.ratio(), 100.0 * row.foretold, row.foretoldRatio(),
                          row.independent / row.measured, row.edgeShare, row.counts() ? "" : "  (reference too coarse)");
            table += line;
        }
    }
    for (const ForecastView& view : views) {
        if (!view.stopped) continue;
        std::snprintf(line, sizeof line, "stopped after %u samples, estimated %.3f%%, measured %.3f%%: ", view.stopped->samples,
                      100.0 * view.stopped->estimated, 100.0 * view.stopped->measured);
        table += line + view.scene + ", " + view.view + "\n";
    }
    const Summary summary(views);
    auto add = [&](const char* what, const Within& within) {
        std::snprintf(line, sizeof line, "%s: %zu of %zu within %.1f to %.1f (%.0f %%)\n", what, within.within, within.rows,
                      LEAST_RATIO, MOST_RATIO, 100.0 * within.share());
        table += line;
    };
    add("estimated by the film, from 16 samples on", summary.estimated);
    add("foretold from the first 16 samples", summary.foretold);
    add("if samples were independent", summary.independent);
    std::snprintf(line, sizeof line, "views all of whose forecasts are within: %zu of %zu\n", summary.viewsWithin,
                  summary.views);
    table += line;
    return table;
}

}  // namespace heliograph

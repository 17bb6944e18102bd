#include "server/lab/live/autopilot_check.h"

#include "server/base/clock.h"
#include "server/film/stats.h"
#include "server/render/frame_renderer.h"
#include "server/render/pass_renderer.h"
#include "server/request/effect_rules.h"
#include "server/request/surroundings.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace heliograph {

namespace {

/// Renders pictures of one pass, as a moving viewer gets them.
class Flyer {
public:
    Flyer(Renderer& renderer, const FrameRequest& request) : renderer_(renderer), request_(request) {}

    /// Seconds of the picture with these settings at this part of the full width, and its pixels.
    double fly(const Scene& scene, const Camera& camera, const Settings& settings, double scale) {
        request_.camera = camera;
        request_.settings = settings;
        request_.effects = effectsUnder(scene, effectsOf(scene), settings);
        const uvec2 full = full_.x > 0 ? full_ : (full_ = request_.resolution);
        request_.resolution = glm::max(uvec2(glm::round(glm::dvec2(full) * scale)), uvec2(1));
        request_.generation++;
        const StopWatch watch;
        film_.reset(request_.resolution, request_.generation);
        PassFigures figures;
        passes_.render({renderer_, request_, film_, view_}, figures);
        return watch.seconds();
    }
    double pixels() const { return static_cast<double>(request_.resolution.x) * request_.resolution.y; }

private:
    Renderer& renderer_;
    FrameRequest request_;
    uvec2 full_{0, 0};
    Film film_;
    ViewMemory view_;
    PassRenderer passes_;
};

int changesOf(const AutopilotFlight& flight) {
    int changes = 0;
    for (size_t i = 1; i < flight.frames.size(); i++) {
        const LadderChoice &a = flight.frames[i - 1].at, &b = flight.frames[i].at;
        changes += a.rung != b.rung || a.step != b.step;
    }
    return changes;
}

FrameSummary summaryOf(const AutopilotFlight& flight) {
    std::vector<double> milliseconds;
    for (const AutopilotFrame& frame : flight.frames) milliseconds.push_back(1e3 * frame.seconds);
    return summarize(milliseconds);
}

double worstOf(const AutopilotFlight& flight) {
    return std::ranges::max_element(flight.frames, {}, &AutopilotFrame::seconds)->seconds;
}

nlohmann::ordered_json frontJson(const AutopilotFlight& flight) {
    if (!flight.front) return nullptr;
    const FrontPlace& place = *flight.front;
    return {{"share", place.share},
            {"set", place.set},
            {"ms", place.ms},
            {"error", place.error},
            {"best", place.best},
            {"best_ms", place.bestMs},
            {"best_error", place.bestError},
            {"reference_error", place.referenceError},
            {"ratio", place.ratio()}};
}

std::string frontLines(const FrontPlace& place) {
    char line[160];
    std::snprintf(line, sizeof line, "  beside the front, %.0f %% of the frames: %.1f ms, error %.2f %%: ", 100.0 * place.share,
                  place.ms, 100.0 * place.error);
    std::string text = line + place.set + "\n";
    std::snprintf(line, sizeof line, "  best for the time: %.1f ms, %.2f %% (reference %.2f %%), ratio %.2f: ", place.bestMs,
                  100.0 * place.bestError, 100.0 * place.referenceError, place.ratio());
    return text + line + place.best + "\n";
}

}  // namespace

double AutopilotFlight::within(double budgets) const {
    const auto held = std::ranges::count_if(frames, [&](const AutopilotFrame& f) { return f.seconds <= budgets * budget; });
    return static_cast<double>(held) / static_cast<double>(frames.size());
}

AutopilotFlight flyWithAutopilot(Renderer& renderer, const Scene& scene, FrameRequest request, const AutopilotBounds& bounds,
                                 const Progress& progress) {
    constexpr int RESTING = 3;  // pictures before the flight: as much as a viewer has seen before it moves
    AutopilotFlight flight{scene.name, request.resolution, bounds.budget, 0.0, ladderOf(request.settings, effectsOf(scene)),
                           {},         std::nullopt};
    std::vector<double> shares;
    for (const LadderRung& rung : flight.rungs) shares.push_back(rung.share);
    LadderCosts costs;
    costs.begin(shares);
    Flyer flyer(renderer, request);
    const CameraPath& path = scene.paths.front();
    const float fieldOfView = request.camera.fieldOfView;
    const double pixels = static_cast<double>(request.resolution.x) * request.resolution.y;
    for (int i = 0; i < RESTING; i++) {
        flight.wholeSeconds = flyer.fly(scene, cameraOnPath(path, 0.0, fieldOfView), request.settings, 1.0);
        costs.add(0, flyer.pixels(), flight.wholeSeconds);
    }
    LadderChoice at = firstPlace(costs, pixels, bounds.budget);
    for (uint32_t frame = 0; frame < bounds.frames; frame++) {
        const Camera camera = cameraOnPath(path, static_cast<double>(frame) / bounds.frames, fieldOfView);
        const double seconds = flyer.fly(scene, camera, flight.rungs[at.rung].settings, scaleOf(at.step));
        flight.frames.push_back({seconds, at});
        costs.add(at.rung, flyer.pixels(), seconds);
        at = nextPlace(at, costs, pixels, bounds.budget, std::max(seconds, 1.0 / bounds.framesPerSecond));
        report(progress, "flying", (frame + 1.0) / bounds.frames);
    }
    return flight;
}

nlohmann::ordered_json toJson(const std::vector<AutopilotFlight>& flights) {
    nlohmann::ordered_json json;
    json["held_within"] = HELD_WITHIN;
    json["flights"] = nlohmann::ordered_json::array();
    for (const AutopilotFlight& flight : flights) {
        const FrameSummary summary = summaryOf(flight);
        std::map<uint32_t, uint32_t> onRung, atStep;
        for (const AutopilotFrame& frame : flight.frames) onRung[frame.at.rung]++, atStep[frame.at.step]++;
        nlohmann::ordered_json rungs = nlohmann::ordered_json::array(), scales = nlohmann::ordered_json::array();
        for (uint32_t i = 0; i < flight.rungs.size(); i++) {
            const LadderRung& rung = flight.rungs[i];
            rungs.push_back({{"setting", rung.setting},
                             {"before", rung.before},
                             {"after", rung.after},
                             {"share", rung.share},
                             {"frames", onRung[i]}});
        }
        for (const auto& [step, frames] : atStep) scales.push_back({{"scale", scaleOf(step)}, {"frames", frames}});
        json["flights"].push_back({{"scene", flight.scene},
                                   {"width", flight.resolution.x},
                                   {"height", flight.resolution.y},
                                   {"budget_ms", 1e3 * flight.budget},
                                   {"whole_ms", 1e3 * flight.wholeSeconds},
                                   {"frames", flight.frames.size()},
                                   {"within", flight.within(HELD_WITHIN)},
                                   {"ms_median", summary.msMedian},
                                   {"ms_p95", summary.msP95},
                                   {"ms_worst", 1e3 * worstOf(flight)},
                                   {"changes", changesOf(flight)},
                                   {"rungs", rungs},
                                   {"scales", scales},
                                   {"front", frontJson(flight)}});
    }
    return json;
}

std::string toTable(const std::vector<AutopilotFlight>& flights) {
    std::string table = "scene                  budget  everything  within 1.15   median      p95    worst  changes\n";
    char line[256];
    for (const AutopilotFlight& flight : flights) {
        const FrameSummary summary = summaryOf(flight);
        std::snprintf(line, sizeof line, "%-20s %5.0f ms %8.0f ms %10.1f %% %6.1f ms %6.1f ms %6.1f ms %6d\n",
                      flight.scene.substr(0, 20).c_str(), 1e3 * flight.budget, 1e3 * flight.wholeSeconds,
                      100.0 * flight.within(HELD_WITHIN), summary.msMedian, summary.msP95, 1e3 * worstOf(flight),
                      changesOf(flight));
        table += line;
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> places;
        for (const AutopilotFrame& frame : flight.frames) places[{frame.at.rung, frame.at.step}]++;
        for (const auto& [place, frames] : places) {
            const LadderRung& rung = flight.rungs[place.first];
            const std::string last = rung.setting.empty() ? "everything" : "down to " + rung.setting + " " + rung.after;
            std::snprintf(line, sizeof line, "  %5.1f %%: %s, %.0f %% of the width\n",
                          100.0 * frames / static_cast<double>(flight.frames.size()), last.c_str(),
                          100.0 * scaleOf(place.second));
            table += line;
        }
        if (flight.front) table += frontLines(*flight.front);
    }
    return table;
}

}  // namespace heliograph

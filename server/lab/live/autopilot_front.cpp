#include "server/lab/live/autopilot_front.h"

#include "server/lab/accuracy/sweep.h"
#include "server/base/text.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace heliograph {

namespace {

using Place = std::pair<uint32_t, uint32_t>;  // rung, step

/// Where most frames are, and how many.
std::pair<Place, uint32_t> mostFlown(const AutopilotFlight& flight) {
    std::map<Place, uint32_t> frames;
    for (const AutopilotFrame& frame : flight.frames) frames[{frame.at.rung, frame.at.step}]++;
    return *std::ranges::max_element(frames, {}, &std::pair<const Place, uint32_t>::second);
}

Settings settingsAt(const AutopilotFlight& flight, Place place) {
    Settings settings = flight.rungs[place.first].settings;
    settings.samples = 1;
    settings.renderScale *= static_cast<float>(scaleOf(place.second));
    return settings;
}

/// The largest scale at which the rung would fit into the budget, if its cost were its share of the whole picture's.
uint32_t stepFor(const AutopilotFlight& flight, const LadderRung& rung) {
    uint32_t step = 0;
    while (step + 1 < SCALE_STEPS && flight.wholeSeconds * rung.share * scaleOf(step) * scaleOf(step) > flight.budget) step++;
    return step;
}

AccuracyOptions sweepOf(const Scene& scene, const AutopilotFlight& flight, const FrontBounds& bounds) {
    AccuracyOptions options;
    options.settings = settingsAt(flight, {0, 0});
    options.resolution = flight.resolution;
    options.budgetSeconds = bounds.seconds;
    options.repetitions = bounds.repetitions;
    options.referenceSamples = bounds.references;
    const CameraPath& path = scene.paths.front();
    for (uint32_t i = 0; i < bounds.views; i++) {
        const double at = (i + 0.5) / bounds.views;
        options.views.push_back({path.name, cameraOnPath(path, at, options.settings.fieldOfView)});
    }
    return options;
}

}  // namespace

FrontPlace placeBesideFront(Renderer& renderer, const Scene& scene, const AutopilotFlight& flight, const FrontBounds& bounds,
                            const Progress& progress) {
    RendererFrames frames(renderer);
    AccuracySweep sweep(frames, scene, sweepOf(scene, flight, bounds));
    sweep.run(progress);
    for (uint32_t rung = 0; rung < flight.rungs.size(); rung++) {
        sweep.measure(settingsAt(flight, {rung, stepFor(flight, flight.rungs[rung])}), progress);
    }
    const auto [place, flown] = mostFlown(flight);
    const size_t row = sweep.measure(settingsAt(flight, place), progress);
    auto point = [&](size_t index) -> const AccuracyPoint& { return sweep.points()[sweep.rows()[index].point]; };
    FrontPlace result;
    result.share = flown / static_cast<double>(flight.frames.size());
    result.ms = sweep.timeOf(point(row)).ms;
    result.error = point(row).error.own.rmse;
    const size_t best = sweep.bestWithin(result.ms).value_or(row);
    result.bestMs = sweep.timeOf(point(best)).ms;
    result.bestError = point(best).error.own.rmse;
    result.set = joined(point(row).set, " ");
    result.best = joined(point(best).set, " ");
    result.referenceError = sweep.referenceError(false);
    return result;
}

}  // namespace heliograph

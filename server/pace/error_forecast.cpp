#include "server/pace/error_forecast.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace heliograph {

namespace {

constexpr double MOST_DOUBLINGS = 32.0;  // that are foretold to, from one sample
constexpr double LOOK_BACK = 4.0;        // doublings of the samples
constexpr double STEP = 0.25;            // doublings between the points that count: pictures come ever denser
constexpr double RATE_BACK = 2.0;        // doublings over which samples per second are taken
constexpr double PLATEAU_SLOPE = 0.15;   // below this more samples do not help
constexpr double PLATEAU_SPAN = 2.0;     // doublings that have to be seen for saying so

struct LogPoint {
    double doublings, log, seconds, samples;  // log2 of samples and of error
};

/// Those that the fit rests on, the newest first.
std::vector<LogPoint> fitted(std::span<const ErrorPoint> history) {
    std::vector<LogPoint> points;
    for (auto point = history.rbegin(); point != history.rend(); ++point) {
        if (point->samples == 0 || !(point->error > 0.0 && point->error < 1.0)) continue;
        const double doublings = std::log2(static_cast<double>(point->samples));
        if (!points.empty()) {
            if (points.front().doublings - doublings > LOOK_BACK) break;
            if (points.back().doublings - doublings < STEP) continue;
        }
        points.push_back({doublings, std::log2(point->error), point->seconds, static_cast<double>(point->samples)});
    }
    return points;
}

double rateOf(const std::vector<LogPoint>& points) {
    const LogPoint& newest = points.front();
    double rate = 0.0;
    for (const LogPoint& point : points) {
        if (newest.doublings - point.doublings > RATE_BACK) break;
        if (newest.seconds > point.seconds) rate = (newest.samples - point.samples) / (newest.seconds - point.seconds);
    }
    return rate;
}

}  // namespace

double ErrorForecast::errorAt(double at) const {
    if (samples == 0 || !(at >= samples)) return samples == 0 ? 1.0 : error;
    if (plateau) return error;
    return std::min(1.0, error * law(at) / law(samples));
}

std::optional<double> ErrorForecast::samplesUntil(double wanted) const {
    if (samples == 0 || !(wanted > 0.0)) return std::nullopt;
    if (error <= wanted) return samples;
    double low = std::log2(static_cast<double>(samples)), high = MOST_DOUBLINGS;
    if (errorAt(std::exp2(high)) > wanted) return std::nullopt;
    for (int step = 0; step < 60; step++) {
        const double middle = 0.5 * (low + high);
        (errorAt(std::exp2(middle)) > wanted ? low : high) = middle;
    }
    return std::exp2(high);
}

std::optional<double> ErrorForecast::secondsUntil(double wanted) const {
    const std::optional<double> until = samplesUntil(wanted);
    if (!until || !(samplesPerSecond > 0.0)) return std::nullopt;
    return (*until - samples) / samplesPerSecond;
}

double independentLaw(double samples) { return 1.0 / std::sqrt(samples); }

ErrorForecast forecastError(std::span<const ErrorPoint> history, ErrorLaw law) {
    ErrorForecast forecast;
    const std::vector<LogPoint> points = fitted(history);
    if (points.empty()) return forecast;
    const LogPoint& newest = points.front();
    forecast.samples = static_cast<uint32_t>(newest.samples);
    forecast.error = std::exp2(newest.log);
    const auto count = static_cast<double>(points.size());
    double meanX = 0.0, meanY = 0.0;
    for (const LogPoint& point : points) {
        meanX += point.doublings / count;
        meanY += point.log / count;
    }
    double xx = 0.0, xy = 0.0;
    for (const LogPoint& point : points) {
        xx += (point.doublings - meanX) * (point.doublings - meanX);
        xy += (point.doublings - meanX) * (point.log - meanY);
    }
    const double span = newest.doublings - points.back().doublings;
    forecast.plateau = span >= PLATEAU_SPAN && -xy / xx < PLATEAU_SLOPE;
    forecast.samplesPerSecond = rateOf(points);
    forecast.law = std::move(law);
    return forecast;
}

std::vector<double> roundErrorsBelow(double error, size_t count) {
    std::vector<double> errors;
    if (!(error > 0.0)) return errors;
    for (int decade = static_cast<int>(std::ceil(std::log10(error))); errors.size() < count; decade--) {
        for (double digit : {5.0, 2.0, 1.0}) {
            const double round = digit * std::pow(10.0, decade - 1);
            if (round < error * (1.0 - 1e-9) && errors.size() < count) errors.push_back(round);
        }
    }
    return errors;
}

}  // namespace heliograph

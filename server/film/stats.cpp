#include "server/film/stats.h"

#include <algorithm>
#include <numeric>

namespace heliograph {

double percentile(std::span<const double> values, double share) {
    if (values.empty()) return 0.0;
    std::vector<double> ordered(values.begin(), values.end());
    std::sort(ordered.begin(), ordered.end());
    double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(ordered.size() - 1);
    auto below = static_cast<size_t>(at);
    size_t above = std::min(below + 1, ordered.size() - 1);
    return ordered[below] + (at - static_cast<double>(below)) * (ordered[above] - ordered[below]);
}

double mean(std::span<const double> values) {
    if (values.empty()) return 0.0;
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

FrameSummary summarize(std::span<const double> milliseconds) {
    FrameSummary summary;
    if (milliseconds.empty()) return summary;
    auto rate = [](double ms) { return ms > 0.0 ? 1000.0 / ms : 0.0; };
    summary.frames = static_cast<uint32_t>(milliseconds.size());
    summary.msMean = mean(milliseconds);
    summary.msMedian = median(milliseconds);
    summary.msP95 = percentile(milliseconds, 0.95);
    summary.fpsMean = rate(summary.msMean);
    summary.fpsMin = rate(*std::max_element(milliseconds.begin(), milliseconds.end()));
    return summary;
}

nlohmann::ordered_json toJson(const RayCounts& rays) {
    nlohmann::ordered_json json;
    for (size_t kind = 0; kind < rays.by.size(); kind++) json[RAY_WORDS[kind]] = rays.by[kind];
    json["total"] = rays.total();
    json["untraceable"] = rays.untraceable;
    json["media_underflows"] = rays.mediaUnderflows;
    json["media_overflows"] = rays.mediaOverflows;
    return json;
}

}  // namespace heliograph

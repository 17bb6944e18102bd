#include "server/render/path_run.h"

#include <algorithm>

namespace heliograph {

std::optional<Camera> PathRun::cameraAt(double seconds, float fieldOfView) const {
    if (!(path_.seconds > 0.0f) || seconds >= path_.seconds) return std::nullopt;
    return cameraOnPath(path_, seconds / path_.seconds, fieldOfView);
}

void PathRun::frameDone(double seconds) { ends_.push_back(seconds); }

PathResult PathRun::result() const {
    PathResult result;
    if (ends_.empty()) return result;
    std::vector<double> ms;
    double before = 0.0;
    for (double end : ends_) {
        ms.push_back((end - before) * 1000.0);
        before = end;
    }
    std::sort(ms.begin(), ms.end());
    result.frames = static_cast<uint32_t>(ms.size());
    result.msMean = ends_.back() * 1000.0 / static_cast<double>(ms.size());
    size_t half = ms.size() / 2;
    result.msMedian = ms.size() % 2 == 1 ? ms[half] : 0.5 * (ms[half - 1] + ms[half]);
    result.msP95 = ms[std::min(ms.size() - 1, (ms.size() * 95 + 99) / 100 - 1)];  // nearest rank
    result.fpsMean = result.msMean > 0.0 ? 1000.0 / result.msMean : 0.0;
    result.fpsMin = ms.back() > 0.0 ? 1000.0 / ms.back() : 0.0;
    return result;
}

}  // namespace heliograph

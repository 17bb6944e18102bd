#include "server/loop/path_run.h"

namespace heliograph {

std::optional<Camera> PathRun::cameraAt(double seconds, float fieldOfView) const {
    if (!(path_.seconds > 0.0f) || seconds >= path_.seconds) return std::nullopt;
    return cameraOnPath(path_, seconds / path_.seconds, fieldOfView);
}

void PathRun::frameDone(double seconds) { ends_.push_back(seconds); }

FrameSummary PathRun::result() const {
    std::vector<double> milliseconds;
    double before = 0.0;
    for (double end : ends_) {
        milliseconds.push_back((end - before) * 1000.0);
        before = end;
    }
    return summarize(milliseconds);
}

}  // namespace heliograph

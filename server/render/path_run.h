#pragma once
// A flight along a camera path in real time, and how smooth it was.

#include "server/render/camera.h"

#include <optional>
#include <vector>

namespace heliograph {

/// Frame times of a run: from the end of one frame to the end of the next.
struct PathResult {
    uint32_t frames = 0;
    double msMean = 0.0, msMedian = 0.0, msP95 = 0.0;  // milliseconds
    double fpsMean = 0.0, fpsMin = 0.0;                // fpsMin: of the longest frame
};

class PathRun {
public:
    explicit PathRun(CameraPath path) : path_(std::move(path)) {}

    /// The camera `seconds` after the start; nothing when the path is over.
    std::optional<Camera> cameraAt(double seconds, float fieldOfView) const;
    /// A frame was finished `seconds` after the start.
    void frameDone(double seconds);
    PathResult result() const;

private:
    CameraPath path_;
    std::vector<double> ends_;  // seconds
};

}  // namespace heliograph

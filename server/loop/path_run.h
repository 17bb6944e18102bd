#pragma once
// A flight along a camera path in real time, and how smooth it was.

#include "server/request/camera.h"
#include "server/film/stats.h"

#include <optional>
#include <vector>

namespace heliograph {

class PathRun {
public:
    explicit PathRun(CameraPath path) : path_(std::move(path)) {}

    /// The camera `seconds` after the start; nothing when the path is over.
    std::optional<Camera> cameraAt(double seconds, float fieldOfView) const;
    /// A frame was finished `seconds` after the start.
    void frameDone(double seconds);
    /// Frame times of the run so far: from the end of one frame to the end of the next.
    FrameSummary result() const;

private:
    CameraPath path_;
    std::vector<double> ends_;  // seconds
};

}  // namespace heliograph

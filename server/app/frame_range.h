#pragma once
// Which frames of a camera path `render` makes, when each of them is, and how long the rest will take. Pure.

#include "server/request/camera.h"

#include <cstdint>
#include <optional>
#include <string>

namespace heliograph {

/// First and last frame, both made. Frame 0 is the path's begin.
struct FrameRange {
    uint32_t first = 0;
    uint32_t last = 0;
    uint32_t count() const { return last - first + 1; }
    bool operator==(const FrameRange&) const = default;
};

/// `A:B` or `A`, 0 to 9,999,999. Throws InputError.
FrameRange parsedFrames(const std::string& text);
/// The whole path at `framesPerSecond`: a closed one ends one frame before it begins again.
FrameRange wholePath(const CameraPath& path, double framesPerSecond);
/// The path's camera at a frame; and a frame before it, for motion blur (the same at the begin of an open path).
Camera cameraAtFrame(const CameraPath& path, int64_t frame, double framesPerSecond, float fieldOfView);
/// The scene's path of that name. Throws InputError that lists the names.
const CameraPath& chosenPath(const Scene& scene, const std::string& name);

/// How long the rest takes when `done` of `wanted` frames took `seconds`; nothing before the first.
std::optional<double> secondsLeft(uint32_t done, uint32_t wanted, double seconds);
/// For people: "8 s", "3 min 20 s", "2 h 5 min".
std::string durationText(double seconds);

}  // namespace heliograph

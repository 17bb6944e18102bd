#include "server/app/frame_range.h"

#include "server/base/error.h"
#include "server/base/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace heliograph {

namespace {

constexpr uint32_t LAST_FRAME = 9'999'999;

/// A whole number and nothing else.
bool numberOf(std::string_view text, uint32_t& number) {
    auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() && number <= LAST_FRAME;
}

}  // namespace

FrameRange parsedFrames(const std::string& text) {
    FrameRange range;
    const size_t colon = text.find(':');
    const std::string_view whole = text;
    bool good = numberOf(whole.substr(0, colon), range.first);
    range.last = range.first;
    if (colon != std::string::npos) good = good && numberOf(whole.substr(colon + 1), range.last);
    if (!good || range.last < range.first) {
        throw InputError("--frames", "'" + text + "'", "FIRST:LAST, for example 0:59, up to " + std::to_string(LAST_FRAME));
    }
    return range;
}

FrameRange wholePath(const CameraPath& path, double framesPerSecond) {
    const double steps = std::round(static_cast<double>(path.seconds) * framesPerSecond);
    const double last = path.closed ? steps - 1.0 : steps;
    return {0, static_cast<uint32_t>(std::clamp(last, 0.0, static_cast<double>(LAST_FRAME)))};
}

Camera cameraAtFrame(const CameraPath& path, int64_t frame, double framesPerSecond, float fieldOfView) {
    return cameraOnPath(path, static_cast<double>(frame) / framesPerSecond / static_cast<double>(path.seconds), fieldOfView);
}

const CameraPath& chosenPath(const Scene& scene, const std::string& name) {
    for (const CameraPath& path : scene.paths)
        if (path.name == name) return path;
    if (scene.paths.empty()) throw InputError("--path", "the scene has none", "a scene with a camera path");
    throw InputError("--path", "the scene has no '" + name + "'",
                     joined(scene.paths, ", ", [](const CameraPath& path) { return path.name; }));
}

std::optional<double> secondsLeft(uint32_t done, uint32_t wanted, double seconds) {
    if (done == 0) return {};
    return seconds / done * (wanted - std::min(done, wanted));
}

std::string durationText(double seconds) {
    const auto whole = static_cast<uint64_t>(std::max(0.0, std::round(seconds)));
    if (whole < 60) return std::to_string(whole) + " s";
    if (whole < 3600) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
    return std::to_string(whole / 3600) + " h " + std::to_string(whole / 60 % 60) + " min";
}

}  // namespace heliograph

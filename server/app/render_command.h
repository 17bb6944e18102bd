#pragma once
// `heliograph render`: a picture of a scene into a file.

#include "server/app/scene_options.h"

#include <functional>
#include <iosfwd>
#include <optional>

namespace heliograph {

struct RenderOptions : SceneOptions {
    std::string out;                 // F.png, F.exr or F.jpg
    std::string previousCamera;      // where the camera was a frame ago, for motion blur; empty: it rests
    std::optional<int64_t> samples;  // per pixel; without it the setting's if it was named, else 16
};

/// Renders and prints the result. Returns the exit code; throws InputError before any work if an argument is bad.
int runRender(const RenderOptions& options, std::ostream& out);
/// Declares the command; when it was given, `run` runs it.
void addRenderCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph

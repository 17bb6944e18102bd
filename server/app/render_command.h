#pragma once
// `heliograph render`: a picture of a scene into a file, or one for each frame of a camera path.

#include "server/app/scene_options.h"
#include "server/pool/broker.h"

#include <functional>
#include <iosfwd>
#include <optional>

namespace heliograph {

struct RenderOptions : SceneOptions {
    std::string out;                 // F.png, F.exr or F.jpg; with a path F.%04d.png; - is standard output
    std::string format;              // png, exr or jpg; empty: as the name of `out` says, png for standard output
    std::string path;                // one of the scene's camera paths; empty: a single picture
    std::string frames;              // A:B; empty: the whole path
    double framesPerSecond = 24.0;   // of the path's own time
    bool resume = false;             // frames whose file is there are left alone
    std::string previousCamera;      // where the camera was a frame ago, for motion blur; empty: it rests
    std::optional<int64_t> samples;  // per pixel; without it the setting's if it was named, else 16
    BrokerOptions broker;            // of a pool that renders along; empty: none
    uint32_t poolNodes = 1;          // to wait for
};

/// Renders and prints the result. Returns the exit code; throws InputError before any work if an argument is bad.
int runRender(const RenderOptions& options, std::ostream& out);
/// Declares the command; when it was given, `run` runs it.
void addRenderCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph

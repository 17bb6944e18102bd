#pragma once
// What keeps a viewer's pictures from being larger, better or more. A pure function of what is measured.

#include <cstdint>

namespace heliograph {

enum class Bottleneck { none, server, line, viewer };
/// As it is told: none, server, line or viewer.
const char* wordOf(Bottleneck bottleneck);

struct PaceFigures {
    bool lowered = false;      // pictures of a moving view are smaller because passes take so long
    uint32_t level = 0;        // of the quality ladder
    double lineDelay = 0.0;    // seconds that pictures queue on the line
    double viewerDelay = 0.0;  // and in the viewer
    bool video = false;        // pictures are one, as JPEG was too large for the line
};

/// Pictures that queue, or would at a better quality, are the line's or the viewer's doing, whichever holds them longer; else
/// what is smaller is so because of the server, and a video because of the line.
Bottleneck bottleneckOf(const PaceFigures& figures);

}  // namespace heliograph

#pragma once
// What one viewer wants to see, and the rules by which a newer wish treats the work for an older one. Pure functions.

#include "server/request/camera.h"
#include "server/request/settings.h"

#include <chrono>

namespace heliograph {

struct ViewRequest {
    Camera camera;
    Settings settings;
    uvec2 resolution{0, 0};                            // pixels of the display; the film is `filmSize` of it
    uint32_t viewer = 0;                               // who drives: the input id is its own
    uint32_t inputId = 0;                              // newest input that this request contains
    bool moving = false;                               // the viewer is still at it
    std::chrono::steady_clock::time_point received{};  // when the newest input came
};

/// What a picture that is asked for beside the frames is saved as.
enum class PictureFormat { png, exr, jpg };

/// Pixels that are rendered: the resolution times renderScale, at least 1 x 1.
uvec2 filmSize(const ViewRequest& request);

/// The samples of one may be shown for the other: they differ at most in input id, `moving` and in settings that act after
/// the film (exposure, tone curve, JPEG quality) or only say when to stop (samples).
bool sameFilm(const ViewRequest& a, const ViewRequest& b);
/// Viewer, input id and everything that acts after the film agree too: a picture of one is a picture of the other.
bool samePicture(const ViewRequest& a, const ViewRequest& b);

/// Whether a pass in flight is given up for a newer wish. A first pass (`firstSample` 0) is finished when only the camera
/// moved, else steady motion would never show anything; for the same reason a dragged setting cancels not twice in a row
/// (`cancelledBefore`: the pass before this one was). A refinement is given up at once.
bool cancelsPass(const ViewRequest& running, uint32_t firstSample, bool cancelledBefore, const ViewRequest& newest);

/// How far the film is and what the viewer was last sent of it.
struct Delivery {
    uint32_t samples = 0;  // per pixel, finished
    uint32_t targetSamples = 1;
    uint32_t deliveredSamples = 0;  // in the last frame handed over; 0: none of this film yet
    bool outdated = false;          // that frame shows an older input id or older exposure
    bool finalDelivered = false;    // that frame was marked as the last one
    double secondsSince = 0.0;      // since that frame
};

/// Whether a frame of the film is worth sending. The first sample, a newer input and the last sample always are; between
/// them when the error has fallen by a fifth (1.5 times the samples) but at most ten times a second, and at least every
/// 0.4 s.
bool frameDue(const Delivery& delivery);

/// Tiles for one turn on the device: few while others want it too, so that nobody waits longer than some 10 ms for each of them.
/// `secondsPerTile`: wall time measured last, 0 = unknown: as few as can be, the first ones tell. `workers`: tiles in work at once.
size_t tilesPerTurn(double secondsPerTile, uint32_t workers, bool contended);

}  // namespace heliograph

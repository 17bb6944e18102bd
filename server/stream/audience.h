#pragma once
// Who of those that look at a view is given its newest frame, and under which input id. Pure functions: each viewer is sent the
// newest picture as soon as it has room for one, so a slow one misses pictures, delays nobody, and has the last one in the end.

#include "server/loop/finished_frame.h"

#include <span>

namespace heliograph {

/// What there is to see in a frame of a view, whoever looks.
struct Shown {
    uint32_t generation = 0;
    uint32_t samples = 0;
    bool final = false;
    Settings display;  // what acts after the film; the JPEG quality is each viewer's own
    bool operator==(const Shown&) const = default;
};
Shown shownBy(const FinishedFrame& frame);

/// The last frame that a viewer was given.
struct Given {
    std::optional<Shown> shown;  // nothing: none yet
    uint32_t inputId = 0;
};

/// Whether a viewer should see this frame: there is something else to see than in the last one, or it answers a newer input.
bool wants(const Given& given, const Shown& frame, uint32_t inputId);

/// The newest input of a viewer that a frame shows. `own`: its newest input that every frame shows, as that to watch the view.
uint32_t inputShown(const ViewRequest& frame, uint32_t viewer, uint32_t own);

/// Films of a view that may be in the making of bytes, and be kept for who has no room yet, while the next one is rendered.
constexpr size_t FILMS_HANDED_OUT = 2;

/// Whether the view shall hand over another frame: as soon as one viewer has room for it. Busy too while too many films are in
/// the making; stalled if nobody looks.
Readiness together(std::span<const Readiness> viewers, size_t filmsOut);

}  // namespace heliograph

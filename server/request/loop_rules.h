#pragma once
// What the render loop of a view does next. A pure function of where it stands.

#include "server/request/view_request.h"

namespace heliograph {

/// Whether the other end takes a frame now.
enum class Readiness {
    ready,
    busy,      // soon: the frame before is being encoded
    noCredit,  // when the viewer has acknowledged one
    stalled,   // the viewer has not acknowledged anything for long
};

/// The picture that was asked for beside the frames.
enum class PictureState { none, unfinished, finished };

struct LoopState {
    bool hasWork = false;   // there is a scene and a request, and rendering it has not failed
    bool filmFits = false;  // the film's samples are samples of the newest request
    Delivery delivery;      // of the film, whether it fits or not
    Readiness readiness = Readiness::ready;
    bool alone = false;  // no other viewer waits for the device, or a flight along a path must go on
    PictureState picture = PictureState::none;
    bool pictureTurn = false;  // the last pass was the film's: passes of picture and film alternate
};

enum class LoopAction {
    rest,           // until there is news
    startFilm,      // for the newest request, with its first pass at once: a camera in flight has moved by the next question
    deliverFilm,    // hand it over as a frame
    renderFilm,     // one pass more
    renderPicture,  // one pass of it
    deliverPicture,
};

LoopAction next(const LoopState& state);

}  // namespace heliograph

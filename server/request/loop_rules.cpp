#include "server/request/loop_rules.h"

namespace heliograph {

LoopAction next(const LoopState& state) {
    if (!state.hasWork) return LoopAction::rest;
    const Delivery& film = state.delivery;
    const bool ready = state.readiness == Readiness::ready;
    if (!state.filmFits && film.samples > 0 && film.deliveredSamples == 0) {
        // A first pass is worth seeing, else steady motion would show nothing. Without credit a newer one may replace it, but
        // not at the cost of other viewers.
        if (ready) return LoopAction::deliverFilm;
        if (state.readiness != Readiness::noCredit || !state.alone) return LoopAction::rest;
    }
    if (state.filmFits && ready && frameDue(film)) return LoopAction::deliverFilm;
    const bool unfinished = !state.filmFits || film.samples < film.targetSamples;
    if (state.picture == PictureState::finished && state.readiness != Readiness::busy) return LoopAction::deliverPicture;
    if (state.picture == PictureState::unfinished && (state.pictureTurn || !unfinished)) return LoopAction::renderPicture;
    if (!state.filmFits) return LoopAction::startFilm;
    return unfinished ? LoopAction::renderFilm : LoopAction::rest;
}

}  // namespace heliograph

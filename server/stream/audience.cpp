#include "server/stream/audience.h"

#include <algorithm>

namespace heliograph {

Shown shownBy(const FinishedFrame& frame) {
    Shown shown{frame.generation, frame.samples, frame.final, onlyActing(frame.view.settings, Acts::display)};
    shown.display.jpegQuality = 0;
    return shown;
}

bool wants(const Given& given, const Shown& frame, uint32_t inputId) {
    return !given.shown || *given.shown != frame || given.inputId != inputId;
}

uint32_t inputShown(const ViewRequest& frame, uint32_t viewer, uint32_t own) {
    return frame.viewer == viewer ? std::max(own, frame.inputId) : own;
}

Readiness together(std::span<const Readiness> viewers, size_t filmsOut) {
    const auto best = std::ranges::min_element(viewers);
    if (best == viewers.end()) return Readiness::stalled;
    return *best == Readiness::ready && filmsOut >= FILMS_HANDED_OUT ? Readiness::busy : *best;
}

}  // namespace heliograph

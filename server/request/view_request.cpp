#include "server/request/view_request.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

bool agree(const ViewRequest& a, const ViewRequest& b, Acts acts) {
    return onlyActing(a.settings, acts) == onlyActing(b.settings, acts);
}

bool sameFilmButCamera(const ViewRequest& a, const ViewRequest& b) {
    return a.resolution == b.resolution && agree(a, b, Acts::film);
}

}  // namespace

uvec2 filmSize(const ViewRequest& request) {
    auto scaled = [&](uint32_t pixels) {
        double share = static_cast<double>(request.settings.renderScale);
        return std::max(1u, static_cast<uint32_t>(std::lround(pixels * share)));
    };
    return uvec2(scaled(request.resolution.x), scaled(request.resolution.y));
}

bool sameFilm(const ViewRequest& a, const ViewRequest& b) { return a.camera == b.camera && sameFilmButCamera(a, b); }

bool samePicture(const ViewRequest& a, const ViewRequest& b) {
    return sameFilm(a, b) && a.viewer == b.viewer && a.inputId == b.inputId && agree(a, b, Acts::display);
}

bool cancelsPass(const ViewRequest& running, uint32_t firstSample, bool cancelledBefore, const ViewRequest& newest) {
    if (sameFilm(running, newest)) return false;
    if (firstSample > 0) return true;
    return !sameFilmButCamera(running, newest) && !cancelledBefore;
}

bool frameDue(const Delivery& d) {
    if (d.samples == 0) return false;
    if (d.deliveredSamples == 0 || d.outdated) return true;
    if (d.samples >= d.targetSamples) return !d.finalDelivered;
    if (d.samples <= d.deliveredSamples) return false;
    bool clearer = 2ull * d.samples >= 3ull * d.deliveredSamples;
    return (clearer && d.secondsSince >= 0.1) || d.secondsSince >= 0.4;
}

size_t tilesPerTurn(double secondsPerTile, uint32_t workers, bool contended) {
    // A slice ends when its last tile does: with fewer than some tiles per worker the others would idle meanwhile.
    size_t least = (contended ? 2 : 4) * static_cast<size_t>(std::max(workers, 1u));
    if (!(secondsPerTile > 0.0)) return least;
    double budget = contended ? 0.01 : 0.15;  // seconds
    return std::max(least, static_cast<size_t>(std::min(budget / secondsPerTile, 1e6)));
}

}  // namespace heliograph

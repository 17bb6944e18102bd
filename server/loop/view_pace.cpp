#include "server/loop/view_pace.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr float LEAST_SCALE = 0.125f;  // of the setting `renderScale`

/// Whether a pixel of one costs what a pixel of the other does.
bool costsAlike(const ViewRequest& a, const ViewRequest& b) {
    Settings of = onlyActing(a.settings, Acts::film), as = onlyActing(b.settings, Acts::film);
    of.renderScale = as.renderScale;
    return of == as;
}

double pixelsOf(const ViewRequest& view) {
    const uvec2 size = filmSize(view);
    return static_cast<double>(size.x) * size.y;
}

}  // namespace

uint32_t ViewPace::stepsFor(const ViewRequest& request) const {
    return request.settings.automaticScale && (request.moving || lowered_) ? choice_.step + lineSteps_ : 0;
}

ViewRequest ViewPace::paced(ViewRequest request) const {
    const uint32_t steps = stepsFor(request);
    if (steps == 0) return request;
    const float scale = request.settings.renderScale * static_cast<float>(scaleOf(steps));
    request.settings.renderScale = std::min(request.settings.renderScale, std::max(scale, LEAST_SCALE));
    return request;
}

void ViewPace::asked(const ViewRequest& request) {
    if (!costsAlike(newest_, request)) cost_.forget();
    newest_ = request;
    const bool begins = request.moving && !lowered_;
    lowered_ = lowered_ || request.moving;
    const double perPixel = cost_.perPixel();
    if (begins && perPixel > 0.0) choice_ = firstScale(perPixel * pixelsOf(request), passBudget(request.settings.frameRate));
}

void ViewPace::passed(const ViewRequest& view, double seconds) {
    if (!costsAlike(newest_, view)) return;  // of what the viewer does not want any more
    cost_.add(pixelsOf(view), seconds);
    if (!newest_.moving) return;
    choice_ = nextScale(choice_, cost_.perPixel() * pixelsOf(newest_), passBudget(newest_.settings.frameRate), seconds);
}

void ViewPace::delivered(const ViewRequest& view) {
    if (!view.moving && !newest_.moving) lowered_ = false;
}

ScaleFigures ViewPace::figures() const {
    return {newest_.settings.automaticScale ? choice_.step : 0, cost_.perPixel() * pixelsOf(newest_)};
}

void ViewPace::forget() { cost_.forget(); }

}  // namespace heliograph

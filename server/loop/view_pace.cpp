#include "server/loop/view_pace.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr float LEAST_SCALE = 0.125f;  // of the setting `renderScale`

/// Seconds that a pass may take; 0: no budget is set.
double budgetOf(const ViewRequest& request) { return 1e-3 * static_cast<double>(request.settings.timeBudget); }

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
    if (!request.settings.automaticScale || !(request.moving || lowered_)) return 0;
    return (budgetOf(request) > 0.0 ? place_.step : choice_.step) + lineSteps_;
}

std::optional<uint32_t> ViewPace::rungOf(const ViewRequest& view) const {
    ViewRequest rung = view;
    for (uint32_t i = 0; i < ladder_.size(); i++) {
        rung.settings = ladder_[i].settings;
        if (costsAlike(rung, view)) return i;
    }
    return std::nullopt;
}

/// The ladder for other settings. `alike`: passes cost what they did.
void ViewPace::climb(const Settings& settings, bool alike) {
    ladder_ = settings.timeBudget > 0.0f ? ladderOf(settings, scene_) : std::vector<LadderRung>();
    ladderCosts_.setScales(settings.automaticScale);
    place_.step = std::min(place_.step, ladderCosts_.steps() - 1);
    if (alike && ladder_.size() == ladderCosts_.rungs()) return;
    std::vector<double> shares;
    for (const LadderRung& rung : ladder_) shares.push_back(rung.share);
    if (shares.empty()) shares.push_back(1.0);
    ladderCosts_.begin(shares);
    place_ = {};
}

ViewRequest ViewPace::paced(ViewRequest request) const {
    const uint32_t steps = stepsFor(request);
    const bool hurries = budgetOf(request) > 0.0 && (request.moving || lowered_) && place_.rung < ladder_.size();
    if (hurries) request.settings = ladder_[place_.rung].settings;
    if (steps == 0) return request;
    const float scale = request.settings.renderScale * static_cast<float>(scaleOf(steps));
    request.settings.renderScale = std::min(request.settings.renderScale, std::max(scale, LEAST_SCALE));
    return request;
}

bool ViewPace::smaller(const ViewRequest& paced) const {
    return paced.settings.renderScale < newest_.settings.renderScale || rungOf(paced).value_or(0) > 0;
}

void ViewPace::asked(const ViewRequest& request) {
    const bool alike = costsAlike(newest_, request);
    if (!alike) cost_.forget();
    if (newest_.settings != request.settings) climb(request.settings, alike);
    newest_ = request;
    const bool begins = request.moving && !lowered_;
    lowered_ = lowered_ || request.moving;
    if (begins && budgetOf(request) > 0.0) place_ = firstPlace(ladderCosts_, pixelsOf(request), budgetOf(request));
    const double perPixel = cost_.perPixel();
    if (begins && perPixel > 0.0) choice_ = firstScale(perPixel * pixelsOf(request), passBudget(request.settings.frameRate));
}

void ViewPace::passed(const ViewRequest& view, double seconds) {
    const double budget = budgetOf(newest_);
    if (const std::optional<uint32_t> rung = budget > 0.0 ? rungOf(view) : std::nullopt) {
        ladderCosts_.add(*rung, pixelsOf(view), seconds);
        if (newest_.moving) place_ = nextPlace(place_, ladderCosts_, pixelsOf(newest_), budget, seconds);
    }
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

AutopilotFigures ViewPace::autopilot() const {
    AutopilotFigures figures;
    figures.budget = budgetOf(newest_);
    if (figures.budget <= 0.0) return figures;
    const bool hurries = newest_.moving || lowered_;
    LadderChoice at = hurries ? place_ : LadderChoice{};
    const double pixels = pixelsOf(newest_);
    figures.seconds = passSeconds(ladderCosts_, at, pixels);
    figures.step = at.step;
    for (uint32_t rung = 1; rung <= at.rung && rung < ladder_.size(); rung++) {
        const LadderRung& taken = ladder_[rung];
        figures.steps.push_back(
            {taken.setting, taken.before, taken.after, passSeconds(ladderCosts_, {rung - 1, at.step}, pixels)});
    }
    return figures;
}

void ViewPace::forget(EffectSet scene) {
    cost_.forget();
    scene_ = scene;
    climb(newest_.settings, false);
}

}  // namespace heliograph

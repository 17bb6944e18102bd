#include "server/stream/view.h"

#include "server/base/log.h"
#include "server/base/machine.h"

#include <algorithm>
#include <set>

namespace heliograph {

View::View(SessionHost& host, uint32_t number, std::string id, const Settings& defaults, const SettingCaps& caps)
    : host_(host),
      metrics_(host.metrics()),
      number_(number),
      id_(std::move(id)),
      caps_(caps),
      meter_(host.turns(), [this](EffectMeter::News&& news) { effectCosts(std::move(news)); }),
      accuracyMeter_(host.turns(), [this](AccuracyMeter::News&& news) { accuracy(std::move(news)); }),
      loop_(host.turns(), *this) {
    request_.settings = capped(defaults, caps_);
}

View::~View() {
    std::lock_guard lock(mutex_);
    stop();
}

/// Ends all work without waiting.
void View::stop() {
    ended_ = true;
    sceneOrder_++;
    newest_.reset();
    picture_.reset();
    dropMeasurements();
    loop_.stop();
}

void View::handle(const Viewer& viewer, const CameraMessage& message) {
    std::lock_guard lock(mutex_);
    driver(viewer, CameraMessage::TYPE);
    if (scene_) checkedCamera(message.camera, *scene_->scene);
    request_.camera = message.camera;
    request_.moving = message.moving;
    request_.inputId = message.inputId;
    show();
}

/// Gives the request to the loop.
void View::show() {
    request_.received = Clock::now();
    if (request_.resolution.x > 0 && scene_ && !ended_) loop_.show(request_);
}

Readiness View::readiness() {
    std::lock_guard lock(mutex_);
    std::vector<Readiness> all;
    for (const Seat& seat : seats_) all.push_back(seat.viewer->readiness());
    return together(all, filmsOut());
}

/// By the line of who drives: others have what that one sees, as often as their lines allow.
uint32_t View::coarser() {
    std::lock_guard lock(mutex_);
    return seats_.empty() ? 0 : seats_.front().viewer->coarser();
}

/// Different films that are being made into bytes or are kept.
size_t View::filmsOut() const {
    std::set<std::weak_ptr<const Film>, std::owner_less<>> films;
    if (newest_) films.insert(newest_->film);
    for (const Seat& seat : seats_) {
        if (!seat.film.expired() && seat.viewer->readiness() == Readiness::busy) films.insert(seat.film);
    }
    return films.size();
}

namespace {

void count(const FinishedFrame& frame, Metrics& metrics) {
    if (!frame.picture) metrics.stages[Metrics::render].add(frame.figures.lastPassSeconds);
    metrics.nonfiniteSamples += frame.figures.nonfiniteSamples;
    for (size_t i = 0; i < metrics.rays.size(); i++) metrics.rays[i] += frame.figures.rays.by[i];
    for (const auto& [device, tiles] : frame.figures.tiles) {
        metrics.devices.change(device, [&, tiles = tiles](DeviceCount& count) {
            count.tiles += tiles;
            count.seconds += frame.figures.renderSeconds;
        });
    }
}

}  // namespace

void View::take(FinishedFrame&& frame) {
    count(frame, metrics_);
    std::lock_guard lock(mutex_);
    if (frame.picture) {
        if (frame.picture == pictureAsked_) picture_ = std::move(frame);
    } else {
        frameAt_ = Clock::now();
        const double seconds = frame.figures.lastPassSeconds;
        secondsPerFrame_ = secondsPerFrame_ > 0.0 ? 0.8 * secondsPerFrame_ + 0.2 * seconds : seconds;
        newest_ = std::move(frame);
        shared_ = seats_.size() > 1 ? std::make_shared<SharedPictures>() : nullptr;
    }
    for (Seat& seat : seats_) give(seat);
    forgetNewest();
}

/// Lets go of a frame that everybody has.
void View::forgetNewest() {
    if (!newest_) return;
    const Shown shown = shownBy(*newest_);
    const bool wanted = std::ranges::any_of(seats_, [&](const Seat& seat) {
        return wants(seat.given, shown, inputShown(newest_->view, seat.viewer->number(), seat.inputId));
    });
    if (wanted) return;
    newest_.reset();
    shared_.reset();
}

/// Gives the viewer what waits for it, if it has room.
void View::give(Seat& seat) {
    Viewer& viewer = *seat.viewer;
    const Readiness room = viewer.readiness();
    if (room == Readiness::busy) return;
    if (picture_ && picture_->picture->viewer == viewer.number()) {
        pictureAsked_.reset();
        return viewer.take(*std::exchange(picture_, std::nullopt));
    }
    if (room != Readiness::ready) return;
    if (!newest_) return void(viewer.refine());
    const Shown shown = shownBy(*newest_);
    const uint32_t inputId = inputShown(newest_->view, viewer.number(), seat.inputId);
    if (!wants(seat.given, shown, inputId)) return void(viewer.refine());
    FinishedFrame frame = *newest_;
    frame.view.inputId = inputId;
    seat.film = frame.film;
    viewer.take(std::move(frame), shared_);
    seat.given = {shown, inputId};
}

void View::drained(const Viewer& viewer) {
    {
        std::lock_guard lock(mutex_);
        Seat* seat = seatOf(viewer.number());
        if (!seat) return;
        give(*seat);
        forgetNewest();
    }
    loop_.wake();
}

void View::pathEnded(const FrameSummary& result) {
    std::lock_guard lock(mutex_);
    if (!playing_) return;
    playing_ = false;
    tell(pathMessage(false, result.frames > 0 ? std::optional(result) : std::nullopt));
}

void View::failed(const std::string& what) {
    std::lock_guard lock(mutex_);
    log().error("viewer {}: {}", request_.viewer, what);
    const Seat* seat = pictureAsked_ ? seatOf(pictureAsked_->viewer) : nullptr;
    if (seat) seat->viewer->dropPicture();
    forgetPicture();
    if (what != lastFailure_) tell(errorMessage("rendering failed: " + what, "frame", std::nullopt));
    lastFailure_ = what;
}

/// Nobody waits for the picture that is being made.
void View::forgetPicture() {
    picture_.reset();
    pictureAsked_.reset();
}

void View::tell(const std::string& text) {
    for (const Seat& seat : seats_) seat.viewer->say(text);
}

std::optional<ViewerStats> View::stats(Viewer& viewer, double seconds) const {
    std::lock_guard lock(mutex_);
    if (!scene_) return std::nullopt;
    ViewerStats stats = viewer.takeStats(seconds, loop_.used());
    if (stats.device.empty()) stats.device = scene_->renderer->info().name;
    stats.watchers = watchers();
    stats.scale = loop_.scale();
    stats.autopilot = loop_.autopilot();
    return stats;
}

bool View::hasNews(const Viewer& viewer, size_t watchersTold) const {
    std::lock_guard lock(mutex_);
    return scene_ && (watchers() != watchersTold || viewer.statsChanged(loop_.used()));
}

std::optional<ViewerLoad> View::load(const Viewer& viewer, Clock::time_point now) const {
    constexpr auto RECENT = std::chrono::seconds(5);
    static const uint32_t processors = usableProcessors();
    std::lock_guard lock(mutex_);
    if (seats_.empty() || seats_.front().viewer != &viewer) return std::nullopt;
    if (secondsPerFrame_ <= 0.0) return ViewerLoad{0.0, request_.resolution.x > 0 || now - opened_ < RECENT};
    double making = 0.0;  // the pictures of all who look
    for (const Seat& seat : seats_) making += seat.viewer->pictureSeconds();
    return ViewerLoad{secondsPerFrame_ + making / processors, now - frameAt_ < RECENT};
}

std::vector<RunningStage> View::stages(const Viewer& viewer) const {
    std::vector<RunningStage> stages;
    auto add = [&](const std::optional<RunningStage>& stage) {
        if (stage) stages.push_back(*stage);
    };
    std::lock_guard lock(mutex_);
    if (!seats_.empty() && seats_.front().viewer == &viewer) {
        add(loop_.stage(viewer.number()));
        add(meter_.stage(viewer.number()));
        add(accuracyMeter_.stage(viewer.number()));
    }
    add(viewer.stage());
    return stages;
}

bool View::answered(const Viewer& viewer) const {
    std::lock_guard lock(mutex_);
    const Seat* seat = seatOf(viewer.number());
    if (!seat || !scene_ || request_.resolution.x == 0 || !viewer.visible()) return true;
    const uint32_t asked = inputShown(request_, viewer.number(), seat->inputId);
    return seat->given.shown && seat->given.inputId == asked && viewer.nothingOnItsWay();
}

}  // namespace heliograph

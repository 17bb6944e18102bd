#include "server/loop/frame_loop.h"

#include "server/base/log.h"

#include <cerrno>
#include <system_error>
#include <utility>

namespace heliograph {

namespace {

double secondsBetween(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

}  // namespace

FrameLoop::FrameLoop(Turns& turns, FrameReceiver& receiver, FilmPool films)
    : turns_(turns), receiver_(receiver), passes_(turns), film_(std::move(films)), thread_([this] { return turn(); }) {
    if (!thread_.call()) throw std::system_error(EAGAIN, std::generic_category(), "no thread to draw with");
}

FrameLoop::~FrameLoop() { stop(); }

/// Makes the change, in order with all others, and wakes the loop.
template <typename Change>
void FrameLoop::tell(Change change) {
    {
        std::lock_guard lock(mutex_);
        change();
    }
    thread_.call();  // without a thread the change waits for `retry`
}

void FrameLoop::show(const ViewRequest& request) {
    tell([&] {
        newest_ = request;
        pace_.asked(request);
        retry_ = true;
        const bool giveUp = pass_.running && pass_.cancellable &&
                            cancelsPass(pass_.view, pass_.firstSample, cancelledBefore_, pace_.paced(request));
        if (giveUp) pass_.stop.request_stop();
    });
}

void FrameLoop::setScene(std::shared_ptr<ResidentScene> scene, const std::optional<ViewRequest>& request) {
    tell([&] {
        if (request) newest_ = request;
        pace_.forget(scene ? scene->effects : EffectSet{});
        if (request) pace_.asked(*request);
        newScene_ = std::move(scene);
        sceneChanged_ = true;
        retry_ = true;
        focusAsked_.reset();
        pictureAsked_.reset();
        if (pass_.running) pass_.stop.request_stop();
    });
}

void FrameLoop::playPath(bool playing) {
    tell([&] { playing_ = playing; });
}

void FrameLoop::takePicture(const PictureOrder& order) {
    tell([&] { pictureAsked_ = order; });
}

void FrameLoop::offerAgain() {
    tell([&] { again_ = true; });
}

void FrameLoop::focus(const FocusRequest& request) {
    tell([&] {
        focusAsked_ = request;
        // A refinement would be given up for the new distance anyway.
        if (pass_.running && pass_.cancellable && pass_.firstSample > 0) pass_.stop.request_stop();
    });
}

void FrameLoop::pick(const PickRequest& request) {
    tell([&] {
        pickAsked_ = request;
        if (pass_.running && pass_.cancellable && pass_.firstSample > 0) pass_.stop.request_stop();  // goes on afterwards
    });
}

void FrameLoop::wake() {
    tell([] {});
}

void FrameLoop::stop() {
    std::lock_guard lock(mutex_);
    stopped_ = true;
    if (pass_.running) pass_.stop.request_stop();
}

ScaleFigures FrameLoop::scale() const {
    std::lock_guard lock(mutex_);
    return pace_.figures();
}

AutopilotFigures FrameLoop::autopilot() const {
    std::lock_guard lock(mutex_);
    return pace_.autopilot();
}

std::optional<RunningStage> FrameLoop::stage(uint32_t viewer) const {
    if (const std::optional<double> seconds = passes_.held()) return RunningStage{viewer, "render", *seconds};
    return stages_.running(viewer);
}

bool FrameLoop::turn() {
    {
        std::lock_guard lock(mutex_);
        if (stopped_) return false;
    }
    try {
        takeNews();
        return step();
    } catch (const std::exception& e) {
        giveUp(e.what());
        return false;
    }
}

/// The frame is over, whatever it was that failed. Without memory to say so the viewer hears it with its next input.
void FrameLoop::giveUp(const char* why) {
    endPass(false);
    picture_.reset();
    broken_ = true;
    try {
        receiver_.failed(why);
    } catch (const std::exception&) {
        log().error("a frame was given up: no memory");
    }
}

void FrameLoop::takeNews() {
    const uint32_t coarser = receiver_.coarser();
    std::unique_lock lock(mutex_);
    pace_.setLineSteps(coarser);
    const bool sceneChanged = std::exchange(sceneChanged_, false);
    if (sceneChanged) {
        resident_ = std::move(newScene_);
        newScene_.reset();
        film_.forget();
        picture_.reset();
        pictureWanted_.reset();
        passes_.forget();
    }
    takeRequest();
    if (std::exchange(again_, false)) film_.offerAgain();
    if (retry_) broken_ = false;
    retry_ = false;
    std::optional<bool> playing = std::exchange(playing_, std::nullopt);
    if (pictureAsked_ && resident_ && request_) pictureWanted_ = std::exchange(pictureAsked_, std::nullopt);
    focus_ = std::exchange(focusAsked_, std::nullopt);
    pick_ = std::exchange(pickAsked_, std::nullopt);
    lock.unlock();

    if (run_ && sceneChanged) endRun();
    if (playing) {
        bool hasPath = resident_ && !resident_->scene->paths.empty();
        if (!*playing || !hasPath) endRun();
        else if (!run_) run_ = Run{PathRun(resident_->scene->paths.front()), Clock::now()};
    }
}

/// With the lock held. A run along the path is a measurement: its frames have the size that was asked for.
void FrameLoop::takeRequest() {
    if (newest_) request_ = run_ ? *newest_ : pace_.paced(*newest_);
}

/// Answers what is asked of single rays.
void FrameLoop::askDevice() {
    const std::optional<FocusRequest> focus = std::exchange(focus_, std::nullopt);
    const std::optional<PickRequest> pick = std::exchange(pick_, std::nullopt);
    if (!resident_) return;
    const auto along = [&](const ViewRay& ray, const char* what) {
        auto span = stages_.enter(what);
        return resident_->renderer->depthAlong(ray);
    };
    if (focus) receiver_.focused(*focus, along(focus->ray, "focus"));
    if (pick) receiver_.picked(*pick, along(pick->ray, "pick"), *resident_->scene);
}

bool FrameLoop::step() {
    askDevice();
    const LoopAction action = next(state());
    switch (action) {
        case LoopAction::rest: break;
        case LoopAction::startFilm:
            film_.show(*resident_, *request_);
            renderFilm();
            break;
        case LoopAction::deliverFilm: deliverFilm(); break;
        case LoopAction::renderFilm: renderFilm(); break;
        case LoopAction::renderPicture: renderPicture(); break;
        case LoopAction::deliverPicture: deliverPicture(); break;
    }
    return action != LoopAction::rest;
}

/// Where the loop stands, once what is due by time and by request is taken in.
LoopState FrameLoop::state() {
    LoopState state;
    state.hasWork = resident_ && request_ && !broken_;
    if (!state.hasWork) return state;
    followPath();
    if (std::optional<PictureOrder> order = std::exchange(pictureWanted_, std::nullopt)) startPicture(*order);
    state.filmFits = film_.shows(*request_);
    if (state.filmFits) film_.show(*resident_, *request_);
    state.delivery = film_.delivery();
    state.readiness = receiver_.readiness();
    state.alone = run_ || !turns_.contended();
    if (picture_) state.picture = picture_->state();
    state.pictureTurn = pictureTurn_;
    return state;
}

void FrameLoop::followPath() {
    if (!run_) return;
    auto camera = run_->path.cameraAt(secondsBetween(run_->begin, Clock::now()), request_->camera.fieldOfView);
    if (!camera) return endRun();
    request_->camera = *camera;
    request_->moving = true;
}

void FrameLoop::endRun() {
    FrameSummary result = run_ ? run_->path.result() : FrameSummary{};
    run_.reset();
    receiver_.pathEnded(result);
}

/// Without memory for it the viewer is told why, and the film goes on.
void FrameLoop::startPicture(const PictureOrder& order) {
    try {
        picture_.emplace(order, *resident_, film_, *request_);
    } catch (const std::exception& e) {
        receiver_.failed(e.what());
    }
}

/// Where the filter cannot work its viewer is told why, and gets pictures without it.
void FrameLoop::denoiseFilm() {
    try {
        if (film_.view()->settings.denoiser == 0) denoiserFault_.clear();
        if (!film_.wantsDenoising(*resident_->scene, run_.has_value())) return;
        const std::stop_token stop = beginPass(*film_.view(), film_.samples(), false);
        film_.denoise(passes_, *resident_->renderer, stop);
        endPass(true);
        denoiserFault_.clear();
    } catch (const std::exception& error) {
        endPass(false);
        if (std::exchange(denoiserFault_, error.what()) != error.what()) receiver_.failed(error.what());
    }
}

/// A film that is smaller for the moment is never the last one, however many samples it has.
void FrameLoop::deliverFilm() {
    denoiseFilm();
    FinishedFrame frame = film_.frame(*resident_->scene, run_.has_value());
    {
        std::lock_guard lock(mutex_);
        pace_.delivered(frame.view);
        frame.final = frame.final && !pace_.smaller(frame.view);
    }
    receiver_.take(std::move(frame));
}

void FrameLoop::renderFilm() {
    pictureTurn_ = true;
    const uint32_t first = film_.samples();
    std::stop_token cancelled = beginPass(*film_.view(), first, true);
    {
        auto span = stages_.enter("prepare");
        resident_->renderer->prepare(film_.view()->settings);  // others go on rendering meanwhile
    }
    const Clock::time_point asked = Clock::now();
    std::optional<Turns::Turn> turn = passes_.take(cancelled, film_.urgency());
    if (!turn) return endPass(false);
    if (first == 0) useLatestRequest();
    const bool completed = film_.renderPass(passes_, *resident_->renderer, cancelled, std::move(turn));
    endPass(completed);
    if (completed && film_.view()->moving) denoiseFilm();  // a part of what such a picture takes
    if (completed && film_.passWasWhole()) {
        std::lock_guard lock(mutex_);
        pace_.passed(*film_.view(), secondsBetween(asked, Clock::now()));
    }
    if (completed && run_ && first == 0) run_->path.frameDone(secondsBetween(run_->begin, Clock::now()));
}

/// The wait for the turn may have been long: the pass that is about to begin shows what the viewer wants by now.
void FrameLoop::useLatestRequest() {
    {
        std::lock_guard lock(mutex_);
        takeRequest();
    }
    followPath();
    film_.show(*resident_, *request_);
    std::lock_guard lock(mutex_);
    pass_.view = *film_.view();
}

void FrameLoop::renderPicture() {
    pictureTurn_ = false;
    std::stop_token cancelled = beginPass(picture_->view(), picture_->samples(), false);
    endPass(picture_->renderPass(passes_, *resident_->renderer, cancelled));
}

void FrameLoop::deliverPicture() {
    try {
        const std::stop_token stop = beginPass(picture_->view(), picture_->samples(), false);
        picture_->denoise(*resident_->scene, passes_, *resident_->renderer, stop);
        endPass(true);
    } catch (const std::exception& error) {
        endPass(false);
        receiver_.failed(error.what());  // the picture comes without
    }
    FinishedFrame frame = picture_->frame(*resident_->scene);
    picture_.reset();
    receiver_.take(std::move(frame));
}

std::stop_token FrameLoop::beginPass(const ViewRequest& view, uint32_t firstSample, bool cancellable) {
    std::lock_guard lock(mutex_);
    pass_ = {true, cancellable, view, firstSample, std::stop_source()};
    bool giveUp = stopped_ || sceneChanged_ || (cancellable && (focusAsked_ || pickAsked_) && firstSample > 0) ||
                  (cancellable && newest_ && !run_ && cancelsPass(view, firstSample, cancelledBefore_, pace_.paced(*newest_)));
    if (giveUp) pass_.stop.request_stop();
    return pass_.stop.get_token();
}

void FrameLoop::endPass(bool completed) {
    std::lock_guard lock(mutex_);
    if (!pass_.running) return;
    pass_.running = false;
    if (completed) cancelledBefore_ = false;
    else if (pass_.firstSample == 0) cancelledBefore_ = true;
}

}  // namespace heliograph

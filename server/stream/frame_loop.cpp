#include "server/stream/frame_loop.h"

#include <algorithm>
#include <utility>

namespace heliograph {

namespace {

double secondsBetween(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

/// `before`: where the camera was a frame ago; without it nothing is blurred by motion.
FrameRequest requestFor(const ResidentScene& scene, const ViewRequest& view, uint32_t generation,
                        const std::optional<Camera>& before) {
    FrameRequest request;
    request.camera = view.camera;
    request.settings = view.settings;
    request.effects.bits = scene.effects.bits & allowedEffects(view.settings).bits;
    request.resolution = filmSize(view);
    request.generation = generation;
    request.previousCamera = before;
    if (!before || *before == view.camera) request.effects.bits &= ~EFFECT_MOTION_BLUR;
    return request;
}

}  // namespace

FrameLoop::FrameLoop(Turns& turns, FrameReceiver& receiver, FilmPool films)
    : turns_(turns), receiver_(receiver), passes_(turns), films_(std::move(films)), thread_([this](std::stop_token stop) {
          run(stop);
      }) {}

FrameLoop::~FrameLoop() { stop(); }

void FrameLoop::show(const ViewRequest& request) {
    {
        std::lock_guard lock(mutex_);
        newest_ = request;
        retry_ = true;
        news_++;
        bool giveUp =
            pass_.running && pass_.cancellable && cancelsPass(pass_.view, pass_.firstSample, cancelledBefore_, request);
        if (giveUp) pass_.stop.request_stop();
    }
    changed_.notify_all();
}

void FrameLoop::setScene(std::shared_ptr<ResidentScene> scene, const std::optional<ViewRequest>& request) {
    {
        std::lock_guard lock(mutex_);
        if (request) newest_ = request;
        newScene_ = std::move(scene);
        sceneChanged_ = true;
        retry_ = true;
        pictureAsked_.reset();
        news_++;
        focusAsked_.reset();
        if (pass_.running) pass_.stop.request_stop();
    }
    changed_.notify_all();
}

void FrameLoop::playPath(bool playing) {
    {
        std::lock_guard lock(mutex_);
        playing_ = playing;
        news_++;
    }
    changed_.notify_all();
}

void FrameLoop::takePicture(const PictureOrder& order) {
    {
        std::lock_guard lock(mutex_);
        pictureAsked_ = order;
        news_++;
    }
    changed_.notify_all();
}

void FrameLoop::focus(const FocusRequest& request) {
    {
        std::lock_guard lock(mutex_);
        focusAsked_ = request;
        news_++;
        // A refinement would be given up for the new distance anyway.
        if (pass_.running && pass_.cancellable && pass_.firstSample > 0) pass_.stop.request_stop();
    }
    changed_.notify_all();
}

void FrameLoop::wake() {
    {
        std::lock_guard lock(mutex_);
        news_++;
    }
    changed_.notify_all();
}

void FrameLoop::stop() {
    thread_.request_stop();
    std::lock_guard lock(mutex_);
    stopped_ = true;
    if (pass_.running) pass_.stop.request_stop();
}

void FrameLoop::run(std::stop_token stop) {
    while (!stop.stop_requested()) {
        uint64_t seen = takeNews();
        bool worked = false;
        try {
            worked = step();
        } catch (const std::exception& e) {
            endPass(false);
            picture_.reset();
            broken_ = true;
            receiver_.failed(e.what());
        }
        if (worked) continue;
        std::unique_lock lock(mutex_);
        changed_.wait(lock, stop, [&] { return news_ != seen; });
    }
}

uint64_t FrameLoop::takeNews() {
    std::unique_lock lock(mutex_);
    const bool sceneChanged = std::exchange(sceneChanged_, false);
    if (sceneChanged) {
        resident_ = std::move(newScene_);
        newScene_.reset();
        view_.reset();
        picture_.reset();
        pictureWanted_.reset();
        passes_.forget();
        history_->costs.forget();
        reach_.forget();
    }
    if (newest_) wish_ = newest_;
    if (retry_) broken_ = false;
    retry_ = false;
    std::optional<bool> playing = std::exchange(playing_, std::nullopt);
    if (pictureAsked_ && resident_ && wish_) {
        pictureWanted_ = std::exchange(pictureAsked_, std::nullopt);
    }
    focus_ = std::exchange(focusAsked_, std::nullopt);
    uint64_t seen = news_;
    lock.unlock();

    if (run_ && sceneChanged) endRun();
    if (playing) {
        bool hasPath = resident_ && !resident_->scene->paths.empty();
        if (!*playing || !hasPath) endRun();
        else if (!run_) run_ = Run{PathRun(resident_->scene->paths.front()), Clock::now()};
    }
    return seen;
}

bool FrameLoop::step() {
    if (std::optional<FocusRequest> asked = std::exchange(focus_, std::nullopt); asked && resident_) {
        receiver_.focused(*asked, resident_->device->depthAlong(asked->ray));
    }
    if (!resident_ || !wish_ || broken_) return false;
    followPath();
    if (std::optional<PictureOrder> order = std::exchange(pictureWanted_, std::nullopt)) beginPicture(*order);
    if (!adopt()) return false;
    if (deliver()) return true;
    bool unfinished = samples_ < view_->settings.samples;
    bool picture = picture_ && (pictureTurn_ || !unfinished);
    pictureTurn_ = !picture;
    if (picture) return finishPicture();
    if (unfinished) renderFilm();
    return unfinished;
}

void FrameLoop::followPath() {
    if (!run_) return;
    auto camera = run_->path.cameraAt(secondsBetween(run_->begin, Clock::now()), wish_->camera.fieldOfView);
    if (!camera) return endRun();
    wish_->camera = *camera;
    wish_->moving = true;
}

void FrameLoop::endRun() {
    FrameSummary result = run_ ? run_->path.result() : FrameSummary{};
    run_.reset();
    receiver_.pathEnded(result);
}

/// Makes the wish the film's view. False: the film holds a first pass that the viewer should have before it is overwritten.
bool FrameLoop::adopt() {
    if (showsWish()) {
        view_ = wish_;
        return true;
    }
    bool undelivered = view_ && samples_ > 0 && delivered_.deliveredSamples == 0;
    if (undelivered && !deliver()) {
        // Without credit a newer picture may replace the waiting one, but not at the cost of other viewers.
        Readiness readiness = receiver_.readiness();
        if (readiness == Readiness::ready) return adopt();  // it just became so
        bool idle = readiness == Readiness::noCredit && (run_ || !turns_.contended());
        if (!idle) return false;
    }
    startFilm();
    return true;
}

/// Whether samples of the film are samples of the wish. What moved and is blurred is made again sharp when it rests.
bool FrameLoop::showsWish() const {
    return view_ && sameFilm(*view_, *wish_) && (wish_->moving || !request_.effects.has(EFFECT_MOTION_BLUR));
}

/// Without memory for it the viewer keeps the last picture and is told why.
void FrameLoop::startFilm() {
    const std::optional<Camera> before = view_ && wish_->moving ? std::optional(view_->camera) : std::nullopt;
    view_.reset();
    film_.reset();
    film_ = films_.next(filmSize(*wish_), ++generation_);
    view_ = wish_;
    request_ = requestFor(*resident_, *view_, generation_, before);
    request_.history = history_;
    samples_ = 0;
    delivered_ = {};
    figures_.devices = 0;  // what a pass that was given up left behind is not in this film
}

/// Hands the film over if that is due and the receiver takes it.
bool FrameLoop::deliver() {
    delivered_.samples = samples_;
    delivered_.targetSamples = view_->settings.samples;
    delivered_.outdated = delivered_.deliveredSamples > 0 && !samePicture(deliveredView_, *view_);
    Clock::time_point now = Clock::now();
    delivered_.secondsSince = secondsBetween(deliveredAt_, now);
    if (samples_ < delivered_.targetSamples) delivered_.finalDelivered = false;
    if (!frameDue(delivered_) || receiver_.readiness() != Readiness::ready) return false;

    FinishedFrame frame;
    frame.film = film_;
    frame.size = film_->resolution();
    frame.view = *view_;
    frame.generation = film_->generation();
    frame.samples = samples_;
    frame.final = samples_ >= view_->settings.samples && !run_;
    frame.path = run_.has_value();
    frame.sceneExposure = resident_->scene->exposure;
    frame.inputSeconds = inputSeconds_;
    frame.figures = std::exchange(figures_, PassFigures{});
    delivered_.deliveredSamples = samples_;
    delivered_.finalDelivered = frame.final;
    deliveredView_ = *view_;
    deliveredAt_ = now;
    receiver_.take(std::move(frame));
    return true;
}

void FrameLoop::renderFilm() {
    uint32_t first = samples_;
    std::stop_token cancelled = beginPass(*view_, first, true);
    resident_->device->prepare(view_->settings);  // others go on rendering meanwhile
    std::optional<Turns::Turn> turn = passes_.take(cancelled);
    if (!turn) return endPass(false);
    if (first == 0) {
        useLatestWish();
        inputSeconds_ = secondsBetween(view_->received, Clock::now());
    }
    bool completed = renderPass(request_, *film_, first, cancelled, std::move(turn), figures_);
    endPass(completed);
    if (!completed) return;
    samples_ = film_->completedSamples();
    if (run_ && first == 0) run_->path.frameDone(secondsBetween(run_->begin, Clock::now()));
}

/// The wait for the turn may have been long: the pass that is about to begin shows what the viewer wants by now.
void FrameLoop::useLatestWish() {
    {
        std::lock_guard lock(mutex_);
        wish_ = newest_;
    }
    followPath();
    if (showsWish()) view_ = wish_;
    else startFilm();
    std::lock_guard lock(mutex_);
    pass_.view = *view_;
}

/// Without memory for it the viewer is told why, and the film goes on.
void FrameLoop::beginPicture(const PictureOrder& order) {
    try {
        startPicture(order);
    } catch (const std::exception& e) {
        receiver_.failed(e.what());
    }
}

void FrameLoop::startPicture(const PictureOrder& order) {
    Job job;
    job.order = order;
    job.view = view_ ? *view_ : *wish_;
    job.view.settings.renderScale = 1.0f;
    job.samples = std::max(samples_, 1u);
    if (view_ && samples_ > 0 && filmSize(*view_) == view_->resolution) {
        job.film = film_;
        job.request = request_;
    } else {
        job.request = requestFor(*resident_, job.view, ++generation_, std::nullopt);
        job.film = films_.extra(job.request.resolution, job.request.generation);
    }
    job.request.history = std::make_shared<FrameHistory>();
    picture_ = std::move(job);
}

/// One pass of the picture, or its delivery. False when the receiver is not ready for it.
bool FrameLoop::finishPicture() {
    uint32_t finished = picture_->film->completedSamples();
    if (finished < picture_->samples) {
        std::stop_token cancelled = beginPass(picture_->view, finished, false);
        bool completed = renderPass(picture_->request, *picture_->film, finished, cancelled, std::nullopt, picture_->figures);
        endPass(completed);
        return true;
    }
    if (receiver_.readiness() == Readiness::busy) return false;
    FinishedFrame frame;
    frame.picture = picture_->order;
    frame.film = picture_->film;
    frame.size = picture_->film->resolution();
    frame.view = picture_->view;
    frame.generation = picture_->film->generation();
    frame.samples = finished;
    frame.final = true;
    frame.sceneExposure = resident_->scene->exposure;
    frame.figures = picture_->figures;
    picture_.reset();
    receiver_.take(std::move(frame));
    return true;
}

std::stop_token FrameLoop::beginPass(const ViewRequest& view, uint32_t firstSample, bool cancellable) {
    std::lock_guard lock(mutex_);
    pass_ = {true, cancellable, view, firstSample, std::stop_source()};
    bool giveUp = stopped_ || sceneChanged_ || (cancellable && focusAsked_ && firstSample > 0) ||
                  (cancellable && newest_ && !run_ && cancelsPass(view, firstSample, cancelledBefore_, *newest_));
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

bool FrameLoop::renderPass(const FrameRequest& request, Film& film, uint32_t firstSample, std::stop_token cancelled,
                           std::optional<Turns::Turn> turn, PassFigures& figures) {
    FrameRequest complete = request;
    complete.reach = reach_.of(request);
    return passes_.render({*resident_->device, complete, film, firstSample, std::move(cancelled)}, figures, std::move(turn));
}

}  // namespace heliograph

#include "server/stream/frame_loop.h"

#include "server/base/clock.h"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

namespace heliograph {

namespace {

double secondsBetween(std::chrono::steady_clock::time_point from, std::chrono::steady_clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
}

/// The device's bit in the frame header.
uint32_t deviceBit(const std::string& device) {
    if (device.starts_with("embree")) return 1;
    if (device.starts_with("vulkan")) return 2;
    if (device.starts_with("raster")) return 4;
    return 8;
}

/// The report of a device that worked alone since `begin`.
ScheduleReport aloneReport(const Partition& partition, double begin, uint32_t tiles) {
    ScheduleReport report;
    if (partition.devices.empty()) return report;
    report.begin = begin;
    report.end = wallSeconds();
    report.seconds = report.end - begin;
    report.batches = 1;
    DeviceReport device;
    device.name = partition.devices.back();
    device.tiles = tiles;
    report.devices.push_back(device);
    report.workers.push_back({0, 0, {{begin, report.end, tiles, report.seconds}}});
    return report;
}

}  // namespace

FrameLoop::FrameLoop(Turns& turns, FrameReceiver& receiver)
    : turns_(turns), receiver_(receiver), thread_([this](std::stop_token stop) { run(stop); }) {}

FrameLoop::~FrameLoop() { stop(); }

void FrameLoop::show(const ViewRequest& request) {
    {
        std::lock_guard lock(mutex_);
        newest_ = request;
        retry_ = true;
        news_++;
        bool giveUp = pass_.running && pass_.cancellable && cancelsPass(pass_.view, pass_.firstSample, cancelledBefore_, request);
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

void FrameLoop::takePicture() {
    {
        std::lock_guard lock(mutex_);
        pictureAsked_ = true;
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
        secondsPerTile_ = 0.0;
        history_->costs.forget();
        reach_.forget();
    }
    if (newest_) wish_ = newest_;
    if (retry_) broken_ = false;
    retry_ = false;
    std::optional<bool> playing = std::exchange(playing_, std::nullopt);
    if (pictureAsked_ && resident_ && wish_) {
        pictureAsked_ = false;
        startPicture();
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
    // What moved and is blurred is made again sharp when it rests.
    if (view_ && sameFilm(*view_, *wish_) && !(blurred_ && !wish_->moving)) {
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

void FrameLoop::startFilm() {
    if (film_ && film_.use_count() > 1) std::swap(film_, spare_);
    if (!film_ || film_.use_count() > 1) film_ = std::make_shared<Film>();
    film_->reset(filmSize(*wish_), ++generation_);
    cameraBefore_ = view_ && wish_->moving ? std::optional(view_->camera) : std::nullopt;
    view_ = wish_;
    blurred_ = requestFor(*film_, *view_, cameraBefore_).effects.has(EFFECT_MOTION_BLUR);
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
    std::optional<Turns::Turn> turn = turns_.take(account_, cancelled);
    if (!turn) return endPass(false);
    if (first == 0) {
        useLatestWish();
        inputSeconds_ = secondsBetween(view_->received, Clock::now());
    }
    bool completed = renderPass(*film_, *view_, first, cancelled, std::move(turn), figures_, history_);
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
    if (sameFilm(*view_, *wish_) && !(blurred_ && !wish_->moving)) view_ = wish_;
    else startFilm();
    std::lock_guard lock(mutex_);
    pass_.view = *view_;
}

void FrameLoop::startPicture() {
    Job job;
    job.view = view_ ? *view_ : *wish_;
    job.view.settings.renderScale = 1.0f;
    job.samples = std::max(samples_, 1u);
    job.history = std::make_shared<FrameHistory>();
    if (view_ && samples_ > 0 && filmSize(*view_) == view_->resolution) {
        job.film = film_;
    } else {
        job.film = std::make_shared<Film>();
        job.film->reset(filmSize(job.view), ++generation_);
    }
    picture_ = std::move(job);
}

/// One pass of the picture, or its delivery. False when the receiver is not ready for it.
bool FrameLoop::finishPicture() {
    uint32_t finished = picture_->film->completedSamples();
    if (finished < picture_->samples) {
        std::stop_token cancelled = beginPass(picture_->view, finished, false);
        bool completed = renderPass(*picture_->film, picture_->view, finished, cancelled, std::nullopt, picture_->figures,
                                    picture_->history);
        endPass(completed);
        return true;
    }
    if (receiver_.readiness() == Readiness::busy) return false;
    FinishedFrame frame;
    frame.kind = FinishedFrame::Kind::picture;
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
    bool giveUp = stopped_ || sceneChanged_ ||
                  (cancellable && focusAsked_ && firstSample > 0) ||
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

/// `before`: where the camera was a frame ago; without it nothing is blurred by motion.
FrameRequest FrameLoop::requestFor(const Film& film, const ViewRequest& view, const std::optional<Camera>& before) const {
    FrameRequest request;
    request.camera = view.camera;
    request.settings = view.settings;
    request.effects.bits = resident_->effects.bits & allowedEffects(view.settings).bits;
    request.resolution = film.resolution();
    request.generation = film.generation();
    request.previousCamera = before;
    if (!before || *before == view.camera) request.effects.bits &= ~EFFECT_MOTION_BLUR;
    return request;
}

/// One sample for every pixel, a slice of tiles a turn. False when cancelled.
bool FrameLoop::renderPass(Film& film, const ViewRequest& view, uint32_t firstSample, std::stop_token cancelled,
                           std::optional<Turns::Turn> turn, PassFigures& figures,
                           const std::shared_ptr<FrameHistory>& history) {
    FrameRequest request = requestFor(film, view, &film == film_.get() ? cameraBefore_ : std::nullopt);
    const uvec2 cellSize = glm::min(tileSize(view.settings), film.resolution());
    const std::vector<Tile> tiles = film.tilesFor(firstSample, 1, cellSize);
    request.history = history;
    request.reach = reach_.of(request);
    beginHistory(*history, film, view, cellSize);
    std::shared_ptr<Partition> partition;
    if (view.settings.showPartition) {
        partition = std::make_shared<Partition>();
        partition->begin(film.resolution(), cellSize);
    }
    const uint32_t workers = resident_->device->infoFor(view.settings).workers;

    figures.lastRays = {};
    figures.lastPassSeconds = 0.0;
    for (size_t done = 0; done < tiles.size();) {
        if (!turn) {
            std::optional<Turns::Turn> next = turns_.take(account_, cancelled);
            if (!next) return false;
            turn.emplace(std::move(*next));
        }
        size_t count = std::min(tiles.size() - done, tilesPerTurn(secondsPerTile_, workers, turns_.shared(account_)));
        double seconds = renderSlice(request, std::span(tiles).subspan(done, count), film, cancelled, figures, partition.get());
        turn.reset();
        figures.lastPassSeconds += seconds;
        figures.renderSeconds += seconds;
        if (cancelled.stop_requested()) return false;
        double perTile = seconds / static_cast<double>(count);
        secondsPerTile_ = secondsPerTile_ > 0.0 ? 0.5 * (secondsPerTile_ + perTile) : perTile;
        done += count;
    }
    figures.passes++;
    history->costs.end();
    figures.schedule = history->report;
    if (partition && !history->report.devices.empty()) partition->report = history->report;
    figures.partition = std::move(partition);
    if (film.completedSamples() <= firstSample) {
        throw std::runtime_error("device " + resident_->device->infoFor(view.settings).name + " left out tiles of a pass");
    }
    return true;
}

/// Returns the wall time.
double FrameLoop::renderSlice(const FrameRequest& request, std::span<const Tile> tiles, Film& film, std::stop_token cancelled,
                              PassFigures& figures, Partition* partition) {
    std::mutex mutex;
    Clock::time_point begin = Clock::now();
    auto sink = [&](TileResult&& result) {
        if (!film.add(result)) return;
        std::lock_guard lock(mutex);
        figures.rays.add(result.rays);
        figures.lastRays.add(result.rays);
        figures.tiles[result.device]++;
        figures.nonfiniteSamples += result.nonfiniteSamples;
        figures.coreSeconds += result.seconds;
        figures.devices |= deviceBit(result.device);
        if (partition) partition->note(result.tile, result.device);
    };
    const double wall = wallSeconds();
    resident_->device->render(request, tiles, sink, cancelled);
    if (partition) partition->report.append(aloneReport(*partition, wall, static_cast<uint32_t>(tiles.size())));
    return secondsBetween(begin, Clock::now());
}

void FrameLoop::beginHistory(FrameHistory& history, const Film& film, const ViewRequest& view, uvec2 cellSize) {
    history.costs.begin(film.resolution(), cellSize);
    history.report = {};
    const uint32_t samples = film.completedSamples();
    const bool together = Settings::choiceWord("device", view.settings.device) == "hybrid";
    if (samples < 2 || !together) history.errors.clear();
    else if (std::has_single_bit(samples)) history.errors = film.cellErrors(cellSize);
}

}  // namespace heliograph

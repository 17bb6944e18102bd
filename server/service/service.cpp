#include "server/service/service.h"

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/film/film_shares.h"

#include <algorithm>
#include <cstdio>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto TICK = 100ms;
constexpr uint32_t TICKS = 5;  // from one look at a session to the next

std::string wordsOf(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", number);
    return text;
}

std::vector<std::string> namesOf(const std::vector<SceneRecipe>& scenes) {
    std::vector<std::string> names;
    for (const SceneRecipe& scene : scenes) names.push_back(scene.name);
    return names;
}

}  // namespace

Service::Service(ServiceOptions options)
    : options_(std::move(options)),
      cache_(
          options_.openScene,
          [this] {
              DeviceSetOptions switching;
              switching.notice = [this](const std::string& device, const std::string& what) { deviceFailed(device, what); };
              return makeDeviceSet(options_.devices, scheduler_, std::move(switching));
          },
          options_.defaults,
          [this](const char* outcome) {
              metrics_.loads.add(outcome);
              left_++;
          }),
      thumbnails_(
          namesOf(options_.scenes),
          [this](const std::string& name, SceneListener listener) {
              return cache_.open(name, std::move(listener), SceneCache::Stay::no);
          },
          [this](const ResidentScene& resident, std::stop_token stop) {
              Settings settings;
              {
                  std::lock_guard lock(mutex_);
                  settings = current_.defaults;
              }
              return paintThumbnail(resident, settings, scheduler_.turns(), std::move(stop));
          }),
      socket_(options_.socket, *this),
      attendant_([this](std::stop_token stop) { attend(stop); }),
      reaper_([this](std::stop_token stop) { reap(stop); }) {}

Service::~Service() {
    cache_.stop();
    for (const auto& session : sessions()) session->end();
    socket_.stop();
    endKeptViews();
    for (std::jthread* thread : {&attendant_, &reaper_}) {
        thread->request_stop();
        thread->join();
    }
}

void Service::start(std::function<void(std::exception_ptr failure)> done) {
    SceneListener listener;
    listener.progress = [](const std::string& what, double share) { log().debug("{} ({:.0f} %)", what, 100.0 * share); };
    listener.ready = [this, done](const std::shared_ptr<ResidentScene>&) {
        cache_.pin(options_.scenes.front().name);
        {
            std::lock_guard lock(mutex_);
            startThere_ = true;
        }
        done(nullptr);
    };
    listener.failed = [this, done](const std::string& why, std::exception_ptr error) {
        {
            std::lock_guard lock(mutex_);
            startFailure_ = why;
        }
        done(error);
    };
    firstScene_ = cache_.open(options_.scenes.front().name, std::move(listener));
    socket_.start();
}

void Service::reload(const ServiceReload& reload) {
    socket_.reload(reload.access);
    std::lock_guard lock(mutex_);
    current_ = reload;
    watchdog_ = reload.watchdog.count();
}

void Service::drain(std::chrono::milliseconds atMost) {
    ending_ = true;
    for (const auto& session : sessions()) session->drain(atMost);
}

bool Service::drained() const {
    return std::ranges::all_of(sessions(), [](const auto& session) { return session->settled(); });
}

std::vector<std::shared_ptr<Session>> Service::sessions() const {
    std::lock_guard lock(mutex_);
    return sessions_;
}

std::optional<NotReady> Service::unready() const {
    ReadinessFacts facts;
    facts.ending = ending_;
    facts.closed = closed_;
    facts.scene = options_.scenes.front().name;
    facts.stuck = stuck();
    if (const auto none = tooCrowded()) facts.crowded = none->why;
    {
        std::lock_guard lock(mutex_);
        facts.mostViewers = current_.access.maxViewers;
        facts.sceneThere = startThere_;
        facts.sceneFailure = startFailure_;
        facts.viewers = sessions_.size();
    }
    return notReady(facts);
}

SocketHandler::Readiness Service::readiness() {
    const std::optional<NotReady> state = unready();
    return {!state, readinessJson(state)};
}

std::optional<SocketHandler::NoRoom> Service::mayEnter() {
    constexpr int DRAIN_SECONDS = 60;  // an admin drains for longer than a moment
    if (closed_) return NoRoom{"the server is being drained", DRAIN_SECONDS};
    return tooCrowded();
}

/// Why another viewer would see too few frames; nothing where it would not.
std::optional<SocketHandler::NoRoom> Service::tooCrowded() const {
    std::vector<ViewerLoad> inside;
    const auto now = std::chrono::steady_clock::now();
    for (const auto& session : sessions()) {
        if (const std::optional<ViewerLoad> load = session->load(now)) inside.push_back(*load);
    }
    const std::optional<int> later = retryAfter(inside, options_.leastRate);
    if (!later) return {};
    return NoRoom{"another viewer would see less than " + wordsOf(options_.leastRate) + " frames a second; try again in " +
                      std::to_string(*later) + " s",
                  *later};
}

/// Views that are kept for nobody yet are ended before somebody who is here goes without.
std::shared_ptr<void> Service::openScene(const std::string& name, SceneListener listener) {
    std::shared_ptr<void> ticket;
    try {
        ticket = cache_.open(name, listener);
    } catch (const InputError&) {
        if (!endKeptViews()) throw;
        ticket = cache_.open(name, std::move(listener));
    }
    letViewersGoFirst();
    return ticket;
}

/// A scene that is loaded for its small picture waits for those that somebody wants to look at.
void Service::letViewersGoFirst() {
    if (cache_.awaited()) thumbnails_.giveWay();
}

Thumbnail Service::thumbnail(std::string_view scene) {
    if (ending_) return {Thumbnail::State::coming};
    return thumbnails_.ask(scene);
}

uint64_t Service::grantPixels(uint32_t view, uint64_t wanted) {
    const uint64_t granted = grant(view, wanted);
    return granted < wanted && endKeptViews() ? grant(view, wanted) : granted;
}

uint64_t Service::grant(uint32_t view, uint64_t wanted) {
    std::lock_guard lock(mutex_);
    return memory_.grant(view, wanted, current_.access.maxViewers);
}

std::shared_ptr<void> Service::look(uint32_t view) {
    if (!tryLook(view) && !(endKeptViews() && tryLook(view))) return nullptr;
    return {this, [view](Service* service) {
                std::lock_guard lock(service->mutex_);
                service->memory_.lookAway(view);
            }};
}

bool Service::tryLook(uint32_t view) {
    std::lock_guard lock(mutex_);
    return memory_.look(view, current_.access.maxViewers);
}

void Service::viewEnded(std::shared_ptr<View> view) {
    views_.remove(*view);
    {
        std::lock_guard lock(mutex_);
        memory_.end(view->number());
        ended_.push_back(std::move(view));
    }
    someEnded_.notify_all();
}

void Service::viewLeft(std::shared_ptr<View> view) {
    KeptViews::Views tooMany;
    {
        std::lock_guard lock(mutex_);
        tooMany = keptViews_.keep(std::move(view), std::chrono::steady_clock::now() + options_.keepViews, KEPT_VIEWS);
    }
    endViews(std::move(tooMany));
}

/// Those that nobody has come back to. False where there was none.
bool Service::endViews(KeptViews::Views views) {
    bool ended = false;
    for (std::shared_ptr<View>& view : views) {
        if (!view->end()) continue;
        viewEnded(std::move(view));
        ended = true;
    }
    return ended;
}

bool Service::endKeptViews() {
    KeptViews::Views views;
    {
        std::lock_guard lock(mutex_);
        views = keptViews_.all();
    }
    return endViews(std::move(views));
}

std::vector<std::string> Service::stuckViews() const {
    std::vector<RunningStage> stages;
    for (const auto& session : sessions()) std::ranges::copy(session->stages(), std::back_inserter(stages));
    return stuckStages(stages, static_cast<double>(watchdog_));
}

size_t Service::viewerCount() const {
    std::lock_guard lock(mutex_);
    return sessions_.size();
}

/// Of lines about viewers: a flood of them is told to who debugs alone.
LogLevel Service::lineLevel() { return lines_.take(1.0, wallSeconds()) ? LogLevel::info : LogLevel::debug; }

std::shared_ptr<ViewerPeer> Service::opened(std::shared_ptr<ViewerSocket> socket, bool authorized) {
    std::shared_ptr<Session> session;
    try {
        {
            std::lock_guard lock(mutex_);
            Session::Options options{current_.defaults, current_.access.token, authorized, options_.caps};
            SessionHost& host = *this;
            session = std::make_shared<Session>(++lastViewer_, host, socket, std::move(options));
            sessions_.push_back(session);
            entries_[session->viewer()] = {socket, std::chrono::steady_clock::now()};
        }
        logWith(lineLevel(), "viewer " + std::to_string(session->viewer()) + ": connected", {{"viewer", session->viewer()}});
        session->begin();
        return session;
    } catch (const std::exception& e) {  // no thread or no memory for another one; those inside keep theirs
        log().error("viewer refused: {}", e.what());
        socket->close(CloseCode::tryAgainLater, "no means for another viewer; try again later");
        if (session) closed(session, CloseCode::tryAgainLater);
        return nullptr;
    }
}

void Service::closed(std::shared_ptr<ViewerPeer> peer, std::optional<CloseCode> code) {
    auto session = std::static_pointer_cast<Session>(std::move(peer));
    // The page of a viewer whose tab slept comes again, too.
    session->end(options_.keepViews > 0ms && !ending_ && (!code || *code == CloseCode::stalled));
    const std::string reason = closeReason(code);
    metrics_.closes.add(reason);
    logWith(lineLevel(), "viewer " + std::to_string(session->viewer()) + ": gone (" + reason + ")",
            {{"viewer", session->viewer()}, {"reason", reason}, {"code", code ? static_cast<int>(*code) : 0}});
    {
        std::lock_guard lock(mutex_);
        std::erase(sessions_, session);
        entries_.erase(session->viewer());
        ended_.push_back(std::move(session));
    }
    someEnded_.notify_all();
}

void Service::refused(unsigned status, const std::string& why) {
    const std::string reason = refusalReason(status);
    metrics_.refusals.add(reason);
    logWith(LogLevel::debug, "connection refused: " + why, {{"status", status}, {"reason", reason}});
}

std::string Service::metricsText() {
    ServerState state;
    readProcess(state);
    state.ready = !unready();
    state.residentScenes = cache_.residentCount();
    state.loadsWaiting = cache_.loadCount();
    if (options_.poolState) state.pool = options_.poolState();
    {
        std::lock_guard lock(mutex_);
        state.viewers = sessions_.size();
        state.mostViewers = current_.access.maxViewers;
        state.mostFilmPixels = filmBudget(options_.pictureBytes, current_.access.maxViewers).pixels;
        state.filmPixels = memory_.pixels();
        state.views = memory_.views();
        state.pictureBytes = memory_.bytes();
        state.mostPictureBytes = memory_.mostBytes();
    }
    return heliograph::metricsText(metricFamilies(metrics_, state));
}

void Service::deviceFailed(const std::string& device, const std::string& what) {
    metrics_.devices.change(device, [](DeviceCount& count) { count.setAside++; });
    tellEverybody(what);
}

/// A device that is set aside is no fault of the viewers, but they should know why frames look or last different.
void Service::tellEverybody(const std::string& what) {
    for (const auto& session : sessions()) session->notice(what);
}

/// Statistics and time limits of all viewers.
void Service::attend(std::stop_token stop) {
    std::condition_variable_any never;
    for (uint32_t turn = 0; !stop.stop_requested(); turn = (turn + 1) % TICKS) {
        std::vector<std::shared_ptr<Session>> sessions;
        KeptViews::Views over;
        {
            std::unique_lock lock(mutex_);
            never.wait_for(lock, stop, TICK, [] { return false; });
            std::ranges::copy_if(sessions_, std::back_inserter(sessions),
                                 [&](const auto& session) { return session->viewer() % TICKS == turn; });
            over = keptViews_.over(std::chrono::steady_clock::now());
        }
        attendantPart_.beat();
        if (turn == 0) {
            resident_ = heliograph::residentBytes();
            socket_.wake();  // tells that it lives
        }
        endViews(std::move(over));
        auto now = std::chrono::steady_clock::now();
        for (const auto& session : sessions) {
            try {
                session->tick(now);
            } catch (const std::exception& e) {  // no memory: its statistics come later
                log().error("viewer {}: {}", session->viewer(), e.what());
            }
        }
    }
}

/// The end of viewers who have gone. It lasts as long as what their devices are doing, so nothing else may wait for it.
void Service::reap(std::stop_token stop) {
    while (true) {
        std::vector<std::shared_ptr<void>> ended;
        std::unique_lock lock(mutex_);
        someEnded_.wait(lock, stop, [&] { return !ended_.empty(); });
        ended.swap(ended_);
        lock.unlock();
        if (ended.empty()) return;
        left_ += ended.size();
    }
}

}  // namespace heliograph

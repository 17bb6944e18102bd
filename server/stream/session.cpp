#include "server/stream/session.h"

#include "server/base/log.h"
#include "server/net/guard/token.h"

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto STATS_EVERY = 450ms;  // less than the time between two calls of tick
constexpr auto STATS_AT_REST = 30s;  // where nothing but other viewers and memory can have changed
// Whose turn comes within one is told when it begins, so that many at rest wake the socket's thread but once.
using StatsRound = std::chrono::duration<int64_t, std::ratio<5>>;

}  // namespace

Session::Session(uint32_t viewer, SessionHost& host, std::shared_ptr<ViewerSocket> socket, Options options)
    : host_(host),
      metrics_(host.metrics()),
      options_(std::move(options)),
      key_(randomSecret()),
      viewer_(viewer, std::move(socket), metrics_, *this) {}

Session::~Session() {
    end();
    // Its thread calls `drained`.
    viewer_.finish();
}

void Session::begin() {
    if (options_.token.empty() || options_.authorized) welcome();
}

void Session::welcome() {
    const std::vector<SceneRecipe> scenes = host_.scenes();
    const std::vector<std::string> devices = host_.devices();
    const std::shared_ptr<View> own = host_.views().open(host_, options_.defaults, options_.caps);
    {
        std::lock_guard lock(mutex_);
        authorized_ = true;
        statsAt_ = Clock::now();
        viewer_.say(helloMessage(viewer_.number(), own->id(), key_, scenes, devices, options_.caps));
    }
    if (enter(own, host_.look(own->number()), std::nullopt)) own->openFirstScene();
}

/// Looks at this view from now on; false when the viewer has gone meanwhile. Throws InputError where nobody looks at it any more.
bool Session::enter(const std::shared_ptr<View>& view, std::shared_ptr<void> place, std::optional<uint32_t> inputId,
                    const std::string& formerKey) {
    {
        std::lock_guard lock(mutex_);
        if (ended_) return false;
        view_ = view;
        std::swap(place_, place);
    }
    view->join(viewer_, inputId, {key_, formerKey});
    return true;
}

void Session::leave(bool keep) {
    std::shared_ptr<void> place;  // goes after the view was left
    std::shared_ptr<View> looked;
    {
        std::lock_guard lock(mutex_);
        std::swap(looked, view_);
        std::swap(place, place_);
    }
    if (!looked || !looked->leave(viewer_)) return;
    if (keep) host_.viewLeft(std::move(looked));
    else if (looked->end()) host_.viewEnded(std::move(looked));
}

std::shared_ptr<View> Session::view() const {
    std::lock_guard lock(mutex_);
    return view_;
}

template <typename Message>
void Session::handle(const Message& message) {
    if (std::shared_ptr<View> looked = view()) looked->handle(viewer_, message);
}

void Session::receive(std::string_view text) {
    std::string about;
    std::optional<uint32_t> inputId;
    try {
        ViewerMessage message = parseViewerMessage(text);
        if (!authorized_ && !std::holds_alternative<TokenMessage>(message)) {
            viewer_.close(CloseCode::unauthorized, "the first message has to be the token");
            return;
        }
        if (draining() && !std::holds_alternative<AckMessage>(message)) return;
        std::visit(
            [&](const auto& m) {
                about = m.TYPE;
                if constexpr (requires { m.inputId; }) inputId = m.inputId;
            },
            message);
        if (inputId && *inputId < newestInput_) {
            throw InputError("inputId", std::to_string(*inputId), "at least " + std::to_string(newestInput_) + ": ids grow");
        }
        std::visit([&](const auto& m) { handle(m); }, message);
        newestInput_ = inputId.value_or(newestInput_);
    } catch (const MessageError& e) {
        refuse(e, e.about(), e.inputId());
    } catch (const InputError& e) {
        refuse(e, about, inputId);
    } catch (const std::exception& e) {  // no memory or no thread for what was asked
        log().error("viewer {}: {}", viewer_.number(), e.what());
        viewer_.close(CloseCode::serverError, "out of memory");
    }
}

/// Tells the viewer what is wrong with its message. `about`: the message's type.
void Session::refuse(const InputError& error, const std::string& about, std::optional<uint32_t> inputId) {
    metrics_.messagesRefused++;
    viewer_.say(errorMessage(error.what(), about, inputId));
}

void Session::handle(const PingMessage& message) {
    if (message.roundTripMs) viewer_.pinged(*message.roundTripMs * 1e-3);
    viewer_.say(pongMessage(message.time));
}

void Session::handle(const TokenMessage& message) {
    if (authorized_) return;  // none is needed, or it was given before
    if (!sameSecret(message.token, options_.token)) {
        metrics_.refusals.add("token");
        log().warn("viewer {}: wrong token", viewer_.number());
        viewer_.close(CloseCode::unauthorized, "wrong token");
        return;
    }
    welcome();
}

/// It leaves the view it looks at before it enters another one, so that one view alone gives it frames.
void Session::handle(const WatchMessage& message) {
    const std::shared_ptr<View> now = view();
    if (!now) return;
    const bool own = !message.view;
    if (own ? now->drives(viewer_) : *message.view == now->id()) return now->stay(viewer_, message.inputId);
    std::shared_ptr<View> next =
        own ? host_.views().open(host_, options_.defaults, options_.caps) : host_.views().find(*message.view);
    if (!next) throw InputError("watch.view", "no such view", "the id of a view that somebody looks at, from its `hello`");
    std::shared_ptr<void> place = host_.look(next->number());
    if (!place) {
        throw InputError("watch.view", "the memory for pictures does not suffice for one more who watches it",
                         "a smaller picture there, or --film-memory of more");
    }
    leave();
    if (enter(next, std::move(place), message.inputId, message.key) && own) next->openFirstScene();
}

void Session::drained() {
    if (std::shared_ptr<View> looked = view()) looked->drained(viewer_);
}

void Session::encodingFailed(const std::string& what) {
    log().error("viewer {}: {}", viewer_.number(), what);
    std::lock_guard lock(mutex_);
    viewer_.dropPicture();
    if (what != lastFailure_) viewer_.say(errorMessage("rendering failed: " + what, "frame", std::nullopt));
    lastFailure_ = what;
}

bool Session::resting() const {
    const std::shared_ptr<View> looked = view();
    return !viewer_.awake() && (!looked || !looked->awake());
}

/// Starts the threads that its view and its viewer did not get when they had something to do; says once where there are none.
void Session::retry() {
    const std::shared_ptr<View> looked = view();
    const bool encodes = viewer_.retry(), renders = !looked || looked->retry();
    const bool waits = !encodes || !renders;
    std::lock_guard lock(mutex_);
    if (waits && !waits_) {
        log().error("viewer {}: no thread to be had for its frames; tried again until there is one", viewer_.number());
        viewer_.say(
            errorMessage("the server has no thread for your frames; it goes on as soon as it has one", "frame", std::nullopt));
    }
    waits_ = waits;
}

void Session::tick(Clock::time_point now) {
    retry();
    std::shared_ptr<View> looked;
    double seconds = 0.0;
    size_t watchers = 0;
    bool restOver = false;
    {
        std::lock_guard lock(mutex_);
        if (ended_) return;
        if (!authorized_) {
            if (now - opened_ > TOKEN_WAIT) viewer_.close(CloseCode::unauthorized, "no token within 5 seconds");
            return;
        }
        if (viewer_.closeIfStalled(now) || now - statsAt_ < STATS_EVERY) return;
        looked = view_;
        seconds = std::chrono::duration<double>(now - statsAt_).count();
        watchers = watchersTold_;
        restOver = std::chrono::floor<StatsRound>(now) - std::chrono::floor<StatsRound>(statsAt_) >= STATS_AT_REST;
    }
    if (!looked || (!restOver && !looked->hasNews(viewer_, watchers))) return;
    std::optional<ViewerStats> stats = looked->stats(viewer_, seconds);
    if (!stats) return;
    stats->viewers = host_.viewerCount();
    stats->residentBytes = host_.residentBytes();
    stats->pool = host_.poolReport();
    std::lock_guard lock(mutex_);
    statsAt_ = now;
    watchersTold_ = stats->watchers;
    viewer_.say(statsMessage(*stats));
}

std::optional<ViewerLoad> Session::load(Clock::time_point now) const {
    if (std::shared_ptr<View> looked = view()) return looked->load(viewer_, now);
    return ViewerLoad{0.0, now - opened_ < 5s};  // it has not said the token yet
}

std::vector<RunningStage> Session::stages() const {
    std::shared_ptr<View> looked = view();
    return looked ? looked->stages(viewer_) : std::vector<RunningStage>();
}

void Session::notice(const std::string& what) {
    std::lock_guard lock(mutex_);
    if (authorized_ && !ended_) viewer_.say(noticeMessage(what));
}

bool Session::draining() const {
    std::lock_guard lock(mutex_);
    return draining_;
}

void Session::drain(std::chrono::milliseconds atMost) {
    std::lock_guard lock(mutex_);
    if (ended_ || draining_) return;
    draining_ = true;
    if (authorized_) viewer_.say(endingMessage(atMost));
}

bool Session::settled() const {
    std::shared_ptr<View> looked = view();
    return !looked || looked->answered(viewer_);
}

void Session::end(bool broken) {
    {
        std::lock_guard lock(mutex_);
        ended_ = true;
    }
    leave(broken && comesBack_);
}

}  // namespace heliograph

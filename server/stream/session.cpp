#include "server/stream/session.h"

#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/film/film_shares.h"
#include "server/net/guard/token.h"

#include <algorithm>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto STATS_EVERY = 500ms;
constexpr auto PROGRESS_EVERY = 100ms;

std::string namesOf(const std::vector<SceneRecipe>& scenes) {
    std::string names;
    for (const SceneRecipe& scene : scenes) names += (names.empty() ? "" : ", ") + scene.name;
    return names;
}

}  // namespace

Session::Session(uint32_t viewer, SessionHost& host, std::shared_ptr<ViewerSocket> socket, Options options)
    : host_(host),
      metrics_(host.metrics()),
      options_(std::move(options)),
      meter_(host.turns(), [this](EffectMeter::News&& news) { effectCosts(std::move(news)); }),
      viewer_(viewer, std::move(socket), metrics_, *this),
      loop_(host.turns(), *this) {
    request_.settings = capped(options_.defaults, options_.caps);
    viewer_.setQuality(request_.settings.jpegQuality);
}

Session::~Session() {
    end();
    // The viewer wakes the loop, so it has to be over before the loop goes.
    viewer_.finish();
}

void Session::begin() {
    if (options_.token.empty() || options_.authorized) welcome();
}

void Session::welcome() {
    std::vector<SceneRecipe> scenes = host_.scenes();
    std::vector<std::string> devices = host_.devices();
    {
        std::lock_guard lock(mutex_);
        authorized_ = true;
        statsAt_ = Clock::now();
        viewer_.say(helloMessage(viewer_.number(), scenes, devices, options_.caps));
        viewer_.say(settingsMessage(request_.settings.toJson(), std::nullopt));
    }
    if (!scenes.empty()) openScene(scenes.front().name);
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

/// Throws InputError unless there is a view to speak of; with the lock held.
void Session::checkVisible(const char* message) const {
    if (!scene_ || request_.resolution.x == 0)
        throw InputError(message, "nothing to see yet", "after `resolution` and a scene");
}

void Session::handle(const CameraMessage& message) {
    std::lock_guard lock(mutex_);
    if (scene_) checkedCamera(message.camera, *scene_->scene);
    request_.camera = message.camera;
    request_.moving = message.moving;
    request_.inputId = message.inputId;
    showLocked();
}

void Session::handle(const SettingsMessage& message) {
    const std::vector<std::string> devices = host_.devices();
    std::lock_guard lock(mutex_);
    Settings settings = request_.settings;
    for (const auto& [name, value] : message.values.items()) {
        if (actsOf(name) == Acts::command)
            throw InputError("settings." + name, "a setting of commands", "the messages `camera` and `path`");
        settings.set(name, value);
    }
    std::string device = Settings::choiceWord("device", settings.device);
    if (message.values.contains("device") && std::ranges::find(devices, device) == devices.end()) {
        std::string words;
        for (const std::string& word : devices) words += (words.empty() ? "one of " : " ") + word;
        throw InputError("settings.device", device + " is not here", words);
    }
    if (settings.device == Settings::choice("device", "hybrid") && nobodyTakesPart(settings)) {
        throw InputError("settings.enableEmbree, settings.enableVulkan", "false, false",
                         "true for one of them at least with device hybrid");
    }
    checkCaps(settings, options_.caps);
    request_.settings = settings;
    request_.inputId = message.inputId;
    viewer_.setQuality(settings.jpegQuality);
    viewer_.say(settingsMessage(settings.toJson(), message.inputId));
    showLocked();
}

void Session::handle(const ResolutionMessage& message) {
    uint64_t pixels = static_cast<uint64_t>(message.size.x) * message.size.y;
    const uvec2 given = largestSize(message.size, host_.grantPixels(viewer_.number(), pixels));
    std::lock_guard lock(mutex_);
    if (given != message.size) viewer_.say(resolutionMessage(message.size, given, message.inputId));
    request_.resolution = given;
    request_.inputId = message.inputId;
    showLocked();
}

void Session::handle(const SceneMessage& message) {
    std::vector<SceneRecipe> scenes = host_.scenes();
    bool known = std::any_of(scenes.begin(), scenes.end(), [&](const SceneRecipe& s) { return s.name == message.name; });
    if (!known) throw InputError("scene.name", nlohmann::json(message.name).dump().substr(0, 80), namesOf(scenes));
    openScene(message.name);
}

void Session::handle(const AckMessage& message) { viewer_.acknowledge(message); }

void Session::handle(const PictureMessage& message) {
    std::lock_guard lock(mutex_);
    checkVisible(PictureMessage::TYPE);
    loop_.takePicture(viewer_.orderPicture(message.format));
}

void Session::handle(const PathMessage& message) {
    std::lock_guard lock(mutex_);
    if (message.playing && (!scene_ || scene_->scene->paths.empty())) {
        throw InputError("path.playing", "true", "false: this scene has no camera path");
    }
    if (message.playing && request_.resolution.x == 0) throw InputError("path.playing", "true", "true after `resolution`");
    // The end of a run is told by pathEnded, with its result.
    if (message.playing || !playing_) viewer_.say(pathMessage(message.playing, std::nullopt));
    if (message.playing == playing_) return;
    playing_ = true;  // until pathEnded
    loop_.playPath(message.playing);
}

void Session::handle(const PingMessage& message) { viewer_.say(pongMessage(message.time)); }

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

void Session::handle(const EffectCostsMessage&) {
    std::lock_guard lock(mutex_);
    checkVisible(EffectCostsMessage::TYPE);
    costsAwaited_ = true;
    costsAt_ = Clock::now();
    viewer_.say(effectCostsMeasuringMessage(0.0));
    meter_.measure({++costsOrder_, sceneName_, scene_, request_});
}

void Session::handle(const FocusMessage& message) {
    std::lock_guard lock(mutex_);
    checkVisible(FocusMessage::TYPE);
    const double aspect = static_cast<double>(request_.resolution.x) / request_.resolution.y;
    loop_.focus({viewRay(request_.camera, aspect, message.x, message.y), message.inputId});
}

/// Sets `focusDistance` to the depth that was measured.
void Session::focused(const FocusRequest& request, const DepthAnswer& answer) {
    std::lock_guard lock(mutex_);
    if (ended_) return;
    try {
        if (!answer.known)
            throw InputError(FocusMessage::TYPE, "no device that holds the scene measures depth", "embree or hybrid as device");
        if (!answer.depth) throw InputError(FocusMessage::TYPE, "nothing is there", "a place where something is seen");
        Settings settings = request_.settings;
        settings.set("focusDistance", *answer.depth);
        request_.settings = settings;
        request_.inputId = std::max(request_.inputId, request.inputId);
        viewer_.say(settingsMessage(settings.toJson(), request.inputId));
        showLocked();
    } catch (const InputError& e) {
        refuse(e, FocusMessage::TYPE, request.inputId);
    }
}

void Session::effectCosts(EffectMeter::News&& news) {
    std::lock_guard lock(mutex_);
    if (ended_ || !costsAwaited_ || news.order != costsOrder_) return;
    if (news.costs || !news.failure.empty()) {
        costsAwaited_ = false;
        viewer_.say(news.costs ? effectCostsReadyMessage(*news.costs) : effectCostsFailedMessage(news.failure));
    } else if (Clock::now() - costsAt_ >= PROGRESS_EVERY) {
        costsAt_ = Clock::now();
        viewer_.say(effectCostsMeasuringMessage(news.share));
    }
}

/// With the lock held.
void Session::dropEffectCosts(const std::string& why) {
    meter_.drop();
    if (costsAwaited_) viewer_.say(effectCostsFailedMessage(why));
    costsAwaited_ = false;
}

/// Gives the request to the loop; with the lock held.
void Session::showLocked() {
    request_.received = Clock::now();
    if (request_.resolution.x > 0 && scene_ && !ended_) loop_.show(request_);
}

void Session::openScene(const std::string& name) {
    uint64_t order;
    std::shared_ptr<void> ticket;
    {
        std::lock_guard lock(mutex_);
        order = ++sceneOrder_;
        orderedName_ = name;
        progressAt_ = {};
        std::swap(sceneTicket_, ticket);
    }
    ticket.reset();  // a load before, which nobody waits for now, takes no place from this one
    SceneListener listener;
    std::weak_ptr<Session> self = weak_from_this();
    listener.progress = [=](const std::string& what, double share) {
        if (auto session = self.lock()) session->sceneProgress(order, what, share);
    };
    listener.ready = [=](std::shared_ptr<ResidentScene> scene) {
        if (auto session = self.lock()) session->sceneReady(order, std::move(scene));
    };
    listener.failed = [=](const std::string& why, std::exception_ptr) {
        if (auto session = self.lock()) session->sceneFailed(order, why);
    };
    try {
        ticket = host_.openScene(name, std::move(listener));
    } catch (const InputError& e) {
        sceneFailed(order, e.what());
        throw;
    }
    std::lock_guard lock(mutex_);
    // Swapped, so that the ticket before goes after the lock.
    if (order == sceneOrder_ && !ended_) std::swap(sceneTicket_, ticket);
}

void Session::sceneProgress(uint64_t order, const std::string& what, double share) {
    std::lock_guard lock(mutex_);
    Clock::time_point now = Clock::now();
    if (order != sceneOrder_ || now - progressAt_ < PROGRESS_EVERY) return;
    progressAt_ = now;
    viewer_.say(sceneLoadingMessage(orderedName_, what, share));
}

void Session::sceneReady(uint64_t order, std::shared_ptr<ResidentScene> scene) {
    std::lock_guard lock(mutex_);
    if (order != sceneOrder_ || ended_) return;
    scene_ = std::move(scene);
    sceneName_ = orderedName_;
    if (viewer_.dropPicture()) {
        viewer_.say(errorMessage("picture: the scene was changed before it was finished", "picture", std::nullopt));
    }
    dropEffectCosts("the scene was changed before they were measured");
    request_.camera = cameraFrom(scene_->scene->cameras.front());
    request_.received = Clock::now();
    viewer_.say(sceneReadyMessage(sceneName_, *scene_->scene, scene_->reasons));
    bool visible = request_.resolution.x > 0;
    loop_.setScene(scene_, visible ? std::optional(request_) : std::nullopt);
}

void Session::sceneFailed(uint64_t order, const std::string& why) {
    std::lock_guard lock(mutex_);
    if (order != sceneOrder_ || ended_) return;
    log().warn("viewer {}: {}", viewer_.number(), why);
    viewer_.say(sceneFailedMessage(orderedName_, why));
}

namespace {

void countDevices(const PassFigures& figures, DeviceCounts& counts) {
    for (const auto& [device, tiles] : figures.tiles) {
        counts.change(device, [&, tiles = tiles](DeviceCount& count) {
            count.tiles += tiles;
            count.seconds += figures.renderSeconds;
        });
    }
}

}  // namespace

void Session::take(FinishedFrame&& frame) {
    if (!frame.picture) {
        metrics_.stages[Metrics::render].add(frame.figures.lastPassSeconds);
        std::lock_guard lock(mutex_);
        frameAt_ = Clock::now();
        const double seconds = frame.figures.lastPassSeconds;
        secondsPerFrame_ = secondsPerFrame_ > 0.0 ? 0.8 * secondsPerFrame_ + 0.2 * seconds : seconds;
    }
    metrics_.nonfiniteSamples += frame.figures.nonfiniteSamples;
    for (size_t i = 0; i < metrics_.rays.size(); i++) metrics_.rays[i] += frame.figures.rays.by[i];
    countDevices(frame.figures, metrics_.devices);
    const bool shown = !frame.picture;
    const uint32_t inputId = frame.view.inputId;
    viewer_.take(std::move(frame));
    // Only now: who drains must find it on its way.
    std::lock_guard lock(mutex_);
    if (shown) shownInput_ = inputId;
}

void Session::pathEnded(const FrameSummary& result) {
    std::lock_guard lock(mutex_);
    if (!playing_) return;
    playing_ = false;
    viewer_.say(pathMessage(false, result.frames > 0 ? std::optional(result) : std::nullopt));
}

void Session::failed(const std::string& what) {
    log().error("viewer {}: {}", viewer_.number(), what);
    std::lock_guard lock(mutex_);
    viewer_.dropPicture();
    if (what != lastFailure_) viewer_.say(errorMessage("rendering failed: " + what, "frame", std::nullopt));
    lastFailure_ = what;
}

void Session::tick(Clock::time_point now) {
    size_t viewers = host_.viewerCount();
    std::lock_guard lock(mutex_);
    if (ended_) return;
    if (!authorized_) {
        if (now - opened_ > TOKEN_WAIT) viewer_.close(CloseCode::unauthorized, "no token within 5 seconds");
        return;
    }
    if (viewer_.closeIfStalled(now)) return;
    if (now - statsAt_ < STATS_EVERY || !scene_) return;
    ViewerStats stats = viewer_.takeStats(std::chrono::duration<double>(now - statsAt_).count(), loop_.used());
    statsAt_ = now;
    if (stats.device.empty()) stats.device = scene_->renderer->info().name;
    stats.viewers = viewers;
    stats.residentBytes = residentBytes();
    viewer_.say(statsMessage(stats));
}

ViewerLoad Session::load(Clock::time_point now) const {
    constexpr auto RECENT = 5s;
    static const uint32_t processors = usableProcessors();
    std::lock_guard lock(mutex_);
    if (secondsPerFrame_ <= 0.0) return {0.0, request_.resolution.x > 0 || now - opened_ < RECENT};
    return {secondsPerFrame_ + viewer_.pictureSeconds() / processors, now - frameAt_ < RECENT};
}

void Session::notice(const std::string& what) {
    std::lock_guard lock(mutex_);
    if (authorized_ && !ended_) viewer_.say(noticeMessage(what));
}

bool Session::draining() {
    std::lock_guard lock(mutex_);
    return draining_;
}

void Session::drain(std::chrono::milliseconds atMost) {
    std::lock_guard lock(mutex_);
    if (ended_ || draining_) return;
    draining_ = true;
    if (authorized_) viewer_.say(endingMessage(atMost));
}

bool Session::settled() {
    std::lock_guard lock(mutex_);
    const bool looks = authorized_ && scene_ && request_.resolution.x > 0 && !ended_;
    return !looks || (shownInput_ == request_.inputId && viewer_.nothingOnItsWay());
}

void Session::end() {
    std::shared_ptr<void> ticket;
    std::lock_guard lock(mutex_);
    ended_ = true;
    std::swap(ticket, sceneTicket_);
    sceneOrder_++;
    meter_.drop();
    loop_.stop();
}

}  // namespace heliograph

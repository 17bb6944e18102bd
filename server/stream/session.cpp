#include "server/stream/session.h"

#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/net/token.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto TOKEN_WAIT = 5s;
constexpr auto STALL_PAUSE = 2s;   // without an ack for so long, nothing is rendered ahead
constexpr auto STALL_CLOSE = 10s;  // and the connection is closed
constexpr auto STATS_EVERY = 500ms;
constexpr auto PROGRESS_EVERY = 100ms;
constexpr uint32_t FINAL_QUALITY = 92;    // least JPEG quality of the last frame of a view
constexpr uint32_t PICTURE_QUALITY = 95;  // of a JPEG that was asked for

FrameCodec codecOf(PictureFormat format) {
    switch (format) {
        case PictureFormat::exr: return FrameCodec::exr;
        case PictureFormat::jpg: return FrameCodec::jpeg;
        default: return FrameCodec::png;
    }
}

std::string namesOf(const std::vector<SceneRecipe>& scenes) {
    std::string names;
    for (const SceneRecipe& scene : scenes) names += (names.empty() ? "" : ", ") + scene.name;
    return names;
}

}  // namespace

Session::Session(uint32_t viewer, SessionHost& host, std::shared_ptr<ViewerSocket> socket, Options options)
    : viewer_(viewer),
      host_(host),
      socket_(std::move(socket)),
      options_(std::move(options)),
      meter_(host.turns(), [this](EffectMeter::News&& news) { effectCosts(std::move(news)); }),
      publisher_([this](uint32_t frameId, std::optional<Published> result, const std::string& failure) {
          published(frameId, std::move(result), failure);
      }),
      loop_(host.turns(), *this) {
    request_.settings = options_.defaults;
}

Session::~Session() {
    end();
    // The publisher wakes the loop, so it has to be over before the loop goes.
    publisher_.finish();
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
        socket_->sendText(helloMessage(viewer_, scenes, devices));
        socket_->sendText(settingsMessage(request_.settings.toJson(), std::nullopt));
    }
    if (!scenes.empty()) openScene(scenes.front().name);
}

void Session::receive(std::string_view text) {
    std::string about;
    std::optional<uint32_t> inputId;
    try {
        ViewerMessage message = parseViewerMessage(text);
        if (!authorized_ && !std::holds_alternative<TokenMessage>(message)) {
            socket_->close(CloseCode::unauthorized, "the first message has to be the token");
            return;
        }
        std::visit([&](const auto& m) {
            about = m.TYPE;
            if constexpr (requires { m.inputId; }) inputId = m.inputId;
        }, message);
        std::visit([&](const auto& m) { handle(m); }, message);
    } catch (const MessageError& e) {
        host_.metrics().messagesRefused++;
        socket_->sendText(errorMessage(e.what(), e.about(), e.inputId()));
    } catch (const InputError& e) {
        host_.metrics().messagesRefused++;
        socket_->sendText(errorMessage(e.what(), about, inputId));
    }
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
    if (settings.device == Settings::choice("device", "hybrid") && !settings.enableEmbree && !settings.enableVulkan) {
        throw InputError("settings.enableEmbree, settings.enableVulkan", "false, false",
                         "true for one of them at least with device hybrid");
    }
    request_.settings = settings;
    request_.inputId = message.inputId;
    socket_->sendText(settingsMessage(settings.toJson(), message.inputId));
    showLocked();
}

void Session::handle(const ResolutionMessage& message) {
    uint64_t pixels = static_cast<uint64_t>(message.size.x) * message.size.y;
    if (!host_.grantPixels(viewer_, FilmPool::FILMS * pixels)) {
        throw InputError("resolution", std::to_string(pixels) + " pixels", "fewer: all viewers together have used up the memory for films");
    }
    std::lock_guard lock(mutex_);
    request_.resolution = message.size;
    request_.inputId = message.inputId;
    showLocked();
}

void Session::handle(const SceneMessage& message) {
    std::vector<SceneRecipe> scenes = host_.scenes();
    bool known = std::any_of(scenes.begin(), scenes.end(), [&](const SceneRecipe& s) { return s.name == message.name; });
    if (!known) throw InputError("scene.name", nlohmann::json(message.name).dump().substr(0, 80), namesOf(scenes));
    openScene(message.name);
}

void Session::handle(const AckMessage& message) {
    std::lock_guard lock(mutex_);
    if (message.frameId > lastFrameId_) {
        throw InputError("ack.frameId", std::to_string(message.frameId), "at most " + std::to_string(lastFrameId_));
    }
    landed(message.frameId);
    if (message.presentedMs && *message.presentedMs >= 0.0) host_.metrics().motionToPhoton.add(*message.presentedMs * 1e-3);
    loop_.wake();
}

void Session::handle(const PictureMessage& message) {
    std::lock_guard lock(mutex_);
    if (!scene_ || request_.resolution.x == 0) throw InputError("picture", "nothing to see yet", "after `resolution` and a scene");
    if (picture_) throw InputError("picture", "one is being made", "one at a time");
    picture_ = message.format;
    loop_.takePicture();
}

void Session::handle(const PathMessage& message) {
    std::lock_guard lock(mutex_);
    if (message.playing && (!scene_ || scene_->scene->paths.empty())) {
        throw InputError("path.playing", "true", "false: this scene has no camera path");
    }
    if (message.playing && request_.resolution.x == 0) throw InputError("path.playing", "true", "true after `resolution`");
    // The end of a run is told by pathEnded, with its result.
    if (message.playing || !playing_) socket_->sendText(pathMessage(message.playing, std::nullopt));
    if (message.playing == playing_) return;
    playing_ = true;  // until pathEnded
    loop_.playPath(message.playing);
}

void Session::handle(const PingMessage& message) { socket_->sendText(pongMessage(message.time)); }

void Session::handle(const TokenMessage& message) {
    if (authorized_) return;  // none is needed, or it was given before
    if (!sameSecret(message.token, options_.token)) {
        host_.metrics().connectionsRefused++;
        log().warn("viewer {}: wrong token", viewer_);
        socket_->close(CloseCode::unauthorized, "wrong token");
        return;
    }
    welcome();
}

void Session::handle(const EffectCostsMessage&) {
    std::lock_guard lock(mutex_);
    if (!scene_ || request_.resolution.x == 0) {
        throw InputError("effectCosts", "nothing to see yet", "after `resolution` and a scene");
    }
    costsAwaited_ = true;
    costsAt_ = Clock::now();
    socket_->sendText(effectCostsMeasuringMessage(0.0));
    meter_.measure({++costsOrder_, sceneName_, scene_, request_});
}

void Session::handle(const FocusMessage& message) {
    std::lock_guard lock(mutex_);
    if (!scene_ || request_.resolution.x == 0) throw InputError("focus", "nothing to see yet", "after `resolution` and a scene");
    const double aspect = static_cast<double>(request_.resolution.x) / request_.resolution.y;
    loop_.focus({viewRay(request_.camera, aspect, message.x, message.y), message.inputId});
}

/// Sets `focusDistance` to the depth that was measured.
void Session::focused(const FocusRequest& request, const DepthAnswer& answer) {
    Metrics& metrics = host_.metrics();
    std::lock_guard lock(mutex_);
    if (ended_) return;
    try {
        if (!answer.known) throw InputError("focus", "no device that holds the scene measures depth", "embree or hybrid as device");
        if (!answer.depth) throw InputError("focus", "nothing is there", "a place where something is seen");
        Settings settings = request_.settings;
        settings.set("focusDistance", *answer.depth);
        request_.settings = settings;
        request_.inputId = std::max(request_.inputId, request.inputId);
        socket_->sendText(settingsMessage(settings.toJson(), request.inputId));
        showLocked();
    } catch (const InputError& e) {
        metrics.messagesRefused++;
        socket_->sendText(errorMessage(e.what(), "focus", request.inputId));
    }
}

void Session::effectCosts(EffectMeter::News&& news) {
    std::lock_guard lock(mutex_);
    if (ended_ || !costsAwaited_ || news.order != costsOrder_) return;
    if (news.costs || !news.failure.empty()) {
        costsAwaited_ = false;
        socket_->sendText(news.costs ? effectCostsReadyMessage(*news.costs) : effectCostsFailedMessage(news.failure));
    } else if (Clock::now() - costsAt_ >= PROGRESS_EVERY) {
        costsAt_ = Clock::now();
        socket_->sendText(effectCostsMeasuringMessage(news.share));
    }
}

/// With the lock held.
void Session::dropEffectCosts(const std::string& why) {
    meter_.drop();
    if (costsAwaited_) socket_->sendText(effectCostsFailedMessage(why));
    costsAwaited_ = false;
}

/// Gives the request to the loop; with the lock held.
void Session::showLocked() {
    request_.received = Clock::now();
    if (request_.resolution.x > 0 && scene_ && !ended_) loop_.show(request_);
}

void Session::openScene(const std::string& name) {
    uint64_t order;
    {
        std::lock_guard lock(mutex_);
        order = ++sceneOrder_;
        orderedName_ = name;
        progressAt_ = {};
    }
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
    std::shared_ptr<void> ticket;
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
    socket_->sendText(sceneLoadingMessage(orderedName_, what, share));
}

void Session::sceneReady(uint64_t order, std::shared_ptr<ResidentScene> scene) {
    std::lock_guard lock(mutex_);
    if (order != sceneOrder_ || ended_) return;
    scene_ = std::move(scene);
    sceneName_ = orderedName_;
    if (picture_) {
        picture_.reset();
        socket_->sendText(errorMessage("picture: the scene was changed before it was finished", "picture", std::nullopt));
    }
    dropEffectCosts("the scene was changed before they were measured");
    request_.camera = cameraFrom(scene_->scene->cameras.front());
    request_.received = Clock::now();
    socket_->sendText(sceneReadyMessage(sceneName_, *scene_->scene, scene_->reasons));
    bool visible = request_.resolution.x > 0;
    loop_.setScene(scene_, visible ? std::optional(request_) : std::nullopt);
}

void Session::sceneFailed(uint64_t order, const std::string& why) {
    std::lock_guard lock(mutex_);
    if (order != sceneOrder_ || ended_) return;
    log().warn("viewer {}: {}", viewer_, why);
    socket_->sendText(sceneFailedMessage(orderedName_, why));
}

Readiness Session::readiness() {
    if (publisher_.busy()) return Readiness::busy;
    std::lock_guard lock(mutex_);
    if (flights_.size() < MAX_UNACKED) return Readiness::ready;
    return Clock::now() - flights_.front().since > STALL_PAUSE ? Readiness::stalled : Readiness::noCredit;
}

void Session::take(FinishedFrame&& frame) {
    Publisher::Order order;
    {
        std::lock_guard lock(mutex_);
        order.frameId = ++lastFrameId_;
        uint32_t quality = frame.view.settings.jpegQuality;
        if (frame.kind == FinishedFrame::Kind::frame) {
            flights_.push_back({order.frameId, Clock::now()});
            order.quality = frame.final ? std::max(quality, FINAL_QUALITY) : quality;
        } else {
            order.codec = codecOf(picture_.value_or(PictureFormat::png));
            order.quality = PICTURE_QUALITY;
        }
    }
    order.frame = std::move(frame);
    publisher_.publish(std::move(order));
}

void Session::published(uint32_t frameId, std::optional<Published> result, const std::string& failure) {
    if (!result) {
        failed(failure);
        std::lock_guard lock(mutex_);
        landed(frameId);
        loop_.wake();
        return;
    }
    Metrics& metrics = host_.metrics();
    metrics.stages[Metrics::develop].add(result->costs.developSeconds);
    metrics.stages[Metrics::encode].add(result->costs.encodeSeconds);
    metrics.nonfiniteSamples += result->figures.nonfiniteSamples;
    for (size_t i = 0; i < metrics.rays.size(); i++) metrics.rays[i] += result->figures.rays.by[i];
    {
        std::lock_guard lock(mutex_);
        if (result->header.kind == FrameKind::frame) {
            stats_.framePublished(*result);
            metrics.framesSent++;
            metrics.frameBytesSent += result->picture.bytes.size() - SOCKET_HEADROOM;
            metrics.stages[Metrics::input].add(1e-6 * result->header.inputMicros);
            metrics.stages[Metrics::render].add(result->figures.lastPassSeconds);
            if (result->figures.partition) socket_->sendText(partitionMessage(frameId, *result->figures.partition));
        } else {
            picture_.reset();
            metrics.picturesSent++;
        }
        std::optional<uint32_t> replaced = socket_->sendPicture(std::move(result->picture));
        if (replaced) {
            metrics.framesReplaced++;
            landed(*replaced);
        }
    }
    loop_.wake();
}

/// The frame is not on its way any more. Pictures and frames acknowledged twice are not found, which is fine.
void Session::landed(uint32_t frameId) {
    std::erase_if(flights_, [&](const Flight& flight) { return flight.frameId == frameId; });
}

void Session::pathEnded(const FrameSummary& result) {
    std::lock_guard lock(mutex_);
    if (!playing_) return;
    playing_ = false;
    socket_->sendText(pathMessage(false, result.frames > 0 ? std::optional(result) : std::nullopt));
}

void Session::failed(const std::string& what) {
    log().error("viewer {}: {}", viewer_, what);
    std::lock_guard lock(mutex_);
    picture_.reset();
    if (what != lastFailure_) socket_->sendText(errorMessage("rendering failed: " + what, "frame", std::nullopt));
    lastFailure_ = what;
}

void Session::written(FrameKind kind, double waitSeconds, double writeSeconds) {
    host_.metrics().stages[Metrics::send].add(waitSeconds);
    if (kind != FrameKind::frame) return;
    std::lock_guard lock(mutex_);
    stats_.frameWritten(waitSeconds, writeSeconds);
}

void Session::tick(Clock::time_point now) {
    size_t viewers = host_.viewerCount();
    std::lock_guard lock(mutex_);
    if (ended_) return;
    if (!authorized_) {
        if (now - opened_ > TOKEN_WAIT) socket_->close(CloseCode::unauthorized, "no token within 5 seconds");
        return;
    }
    if (!flights_.empty() && now - flights_.front().since > STALL_CLOSE) {
        host_.metrics().viewersStalled++;
        log().warn("viewer {}: nothing acknowledged for 10 s, closed", viewer_);
        socket_->close(CloseCode::stalled, "frames were not acknowledged for 10 seconds");
        flights_.clear();  // closed once
        return;
    }
    if (now - statsAt_ < STATS_EVERY || !scene_) return;
    ViewerStats stats = stats_.take(std::chrono::duration<double>(now - statsAt_).count(), loop_.used());
    statsAt_ = now;
    if (stats.device.empty()) stats.device = scene_->device->info().name;
    stats.viewers = viewers;
    stats.residentBytes = residentBytes();
    socket_->sendText(statsMessage(stats));
}

void Session::notice(const std::string& what) {
    std::lock_guard lock(mutex_);
    if (authorized_ && !ended_) socket_->sendText(noticeMessage(what));
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

// What viewers ask of a view beside its camera, and the opening of its scenes.

#include "server/stream/view.h"

#include "server/base/log.h"
#include "server/film/film_shares.h"
#include "server/scene/framing.h"

#include <algorithm>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto PROGRESS_EVERY = 100ms;

std::string namesOf(const std::vector<SceneRecipe>& scenes) {
    std::string names;
    for (const SceneRecipe& scene : scenes) names += (names.empty() ? "" : ", ") + scene.name;
    return names;
}

/// The settings with these values. Throws InputError for the first that may not be.
Settings changed(Settings settings, const nlohmann::json& values, const std::vector<std::string>& devices,
                 const SettingCaps& caps) {
    for (const auto& [name, value] : values.items()) {
        if (actsOf(name) == Acts::command)
            throw InputError("settings." + name, "a setting of commands", "the messages `camera` and `path`");
        settings.set(name, value);
    }
    std::string device = Settings::choiceWord("device", settings.device);
    if (values.contains("device") && std::ranges::find(devices, device) == devices.end()) {
        std::string words;
        for (const std::string& word : devices) words += (words.empty() ? "one of " : " ") + word;
        throw InputError("settings.device", device + " is not here", words);
    }
    if (settings.device == Settings::choice("device", "hybrid") && nobodyTakesPart(settings)) {
        throw InputError("settings.enableEmbree, settings.enableVulkan", "false, false",
                         "true for one of them at least with device hybrid");
    }
    checkCaps(settings, caps);
    return settings;
}

}  // namespace

/// Throws InputError unless there is something to see.
void View::checkVisible(const char* message) const {
    if (!scene_ || request_.resolution.x == 0)
        throw InputError(message, "nothing to see yet", "after `resolution` and a scene");
}

void View::tellSettings(const Seat& seat, std::optional<uint32_t> inputId) const {
    Settings settings = request_.settings;
    settings.jpegQuality = seat.quality;
    seat.viewer->say(settingsMessage(settings.toJson(), inputId));
}

/// Whether it drives the view or watches it.
void View::tellRole(const Seat& seat, std::optional<uint32_t> inputId) const {
    const bool drives = &seat == &seats_.front();
    seat.viewer->say(watchingMessage(id_, drives, drives && scene_ ? &request_.camera : nullptr, inputId));
}

double View::aspect() const {
    const uvec2 size = request_.resolution;
    return size.x > 0 && size.y > 0 ? static_cast<double>(size.x) / size.y : USUAL_ASPECT;
}

void View::tellScene(Viewer& viewer) const {
    if (scene_) viewer.say(sceneReadyMessage(sceneName_, *scene_->scene, scene_->reasons, aspect()));
    if (orderedName_.empty() || (scene_ && orderedName_ == sceneName_)) return;
    viewer.say(sceneFailure_.empty() ? sceneLoadingMessage(orderedName_, "", 0.0)
                                     : sceneFailedMessage(orderedName_, sceneFailure_));
}

void View::handle(Viewer& viewer, const SettingsMessage& message) {
    const std::vector<std::string> devices = host_.devices();
    std::lock_guard lock(mutex_);
    Seat* seat = seatOf(viewer.number());
    if (!seat) return;
    if (seat != &seats_.front()) return changeQuality(*seat, message);
    request_.settings = changed(request_.settings, message.values, devices, caps_);
    lastFailure_.clear();  // what fails again is said again to who asks again
    request_.inputId = message.inputId;
    seat->quality = request_.settings.jpegQuality;
    viewer.setQuality(seat->quality);
    for (const Seat& other : seats_) tellSettings(other, &other == seat ? std::optional(message.inputId) : std::nullopt);
    show();
}

/// All that who watches may set.
void View::changeQuality(Seat& seat, const SettingsMessage& message) {
    Settings settings = request_.settings;
    settings.jpegQuality = seat.quality;
    for (const auto& [name, value] : message.values.items()) {
        settings.set(name, value);
        if (name != "jpegQuality") driver(*seat.viewer, ("settings." + name).c_str());
    }
    seat.quality = settings.jpegQuality;
    seat.inputId = message.inputId;
    seat.viewer->setQuality(seat.quality);
    tellSettings(seat, message.inputId);
    loop_.offerAgain();
}

void View::handle(Viewer& viewer, const ResolutionMessage& message) {
    {
        std::lock_guard lock(mutex_);
        driver(viewer, ResolutionMessage::TYPE);
    }
    uint64_t pixels = static_cast<uint64_t>(message.size.x) * message.size.y;
    const uvec2 given = largestSize(message.size, host_.grantPixels(number_, pixels));
    std::lock_guard lock(mutex_);
    driver(viewer, ResolutionMessage::TYPE);
    if (given != message.size) viewer.say(resolutionMessage(message.size, given, message.inputId));
    request_.resolution = given;
    request_.inputId = message.inputId;
    show();
}

void View::handle(const Viewer& viewer, const SceneMessage& message) {
    {
        std::lock_guard lock(mutex_);
        driver(viewer, SceneMessage::TYPE);
    }
    std::vector<SceneRecipe> scenes = host_.scenes();
    const auto isOffered = [&](const std::string& name) {
        return std::ranges::find(scenes, name, &SceneRecipe::name) != scenes.end() || host_.opensToo(name);
    };
    if (!isOffered(sceneNameOf(message.name, isOffered).name))
        throw InputError("scene.name", nlohmann::json(message.name).dump().substr(0, 80), namesOf(scenes));
    openScene(message.name);
}

void View::handle(Viewer& viewer, const PictureMessage& message) {
    std::lock_guard lock(mutex_);
    checkVisible(PictureMessage::TYPE);
    if (pictureAsked_ && pictureAsked_->viewer != viewer.number())
        throw InputError(PictureMessage::TYPE, "one is being made for another viewer of this view", "one at a time");
    pictureAsked_ = viewer.orderPicture(message.format);
    loop_.takePicture(*pictureAsked_);
}

void View::handle(const Viewer& viewer, const PathMessage& message) {
    std::lock_guard lock(mutex_);
    driver(viewer, PathMessage::TYPE);
    if (message.playing && (!scene_ || scene_->scene->paths.empty())) {
        throw InputError("path.playing", "true", "false: this scene has no camera path");
    }
    if (message.playing && request_.resolution.x == 0) throw InputError("path.playing", "true", "true after `resolution`");
    // The end of a run is told by pathEnded, with its result.
    if (message.playing || !playing_) tell(pathMessage(message.playing, std::nullopt));
    if (message.playing == playing_) return;
    playing_ = true;  // until pathEnded
    loop_.playPath(message.playing);
}

void View::handle(Viewer& viewer, const EffectCostsMessage&) {
    std::lock_guard lock(mutex_);
    driver(viewer, EffectCostsMessage::TYPE);
    checkVisible(EffectCostsMessage::TYPE);
    costsAwaited_ = true;
    costsAt_ = Clock::now();
    viewer.say(effectCostsMeasuringMessage(0.0));
    meter_.measure({++costsOrder_, sceneName_, scene_, request_});
}

void View::handle(Viewer& viewer, const AccuracyMessage& message) {
    std::lock_guard lock(mutex_);
    driver(viewer, AccuracyMessage::TYPE);
    if (message.seconds > 0.0) checkVisible(AccuracyMessage::TYPE);
    giveUpAccuracy();
    if (message.seconds == 0.0) return;
    accuracyAwaited_ = true;
    accuracyAt_ = Clock::now();
    viewer.say(accuracyMeasuringMessage(0.0, ""));
    accuracyMeter_.measure({++accuracyOrder_, sceneName_, scene_, request_, caps_, message.seconds});
}

void View::handle(const Viewer& viewer, const FocusMessage& message) {
    std::lock_guard lock(mutex_);
    driver(viewer, FocusMessage::TYPE);
    checkVisible(FocusMessage::TYPE);
    loop_.focus({rayThrough(message.x, message.y), message.inputId, viewer.number()});
}

void View::handle(const Viewer& viewer, const PickMessage& message) {
    std::lock_guard lock(mutex_);
    driver(viewer, PickMessage::TYPE);
    checkVisible(PickMessage::TYPE);
    loop_.pick({rayThrough(message.x, message.y), message.id, viewer.number()});
}

ViewRay View::rayThrough(double x, double y) const {
    return viewRay(request_.camera, static_cast<double>(request_.resolution.x) / request_.resolution.y, x, y);
}

/// Tells who asked.
void View::picked(const PickRequest& request, const DepthAnswer& answer, const Scene& scene) {
    std::optional<Picked> there;
    if (answer.depth) there = pickedAt(scene, request.ray, *answer.depth, answer.instance, answer.triangle);
    std::lock_guard lock(mutex_);
    if (ended_ || request.viewer != request_.viewer) return;
    Viewer& viewer = *seats_.front().viewer;
    if (answer.known) return viewer.say(pickedMessage(request.id, there));
    metrics_.messagesRefused++;
    const InputError error(PickMessage::TYPE, "no device that holds the scene measures depth", "embree or hybrid as device");
    viewer.say(errorMessage(error.what(), PickMessage::TYPE, std::nullopt));
}

/// Sets `focusDistance` to the depth that was measured.
void View::focused(const FocusRequest& request, const DepthAnswer& answer) {
    std::lock_guard lock(mutex_);
    if (ended_ || request.viewer != request_.viewer) return;
    Seat& seat = seats_.front();
    try {
        if (!answer.known)
            throw InputError(FocusMessage::TYPE, "no device that holds the scene measures depth", "embree or hybrid as device");
        if (!answer.depth) throw InputError(FocusMessage::TYPE, "nothing is there", "a place where something is seen");
        Settings settings = request_.settings;
        settings.set("focusDistance", *answer.depth);
        request_.settings = settings;
        request_.inputId = std::max(request_.inputId, request.inputId);
        for (const Seat& other : seats_) tellSettings(other, &other == &seat ? std::optional(request.inputId) : std::nullopt);
        show();
    } catch (const InputError& e) {
        metrics_.messagesRefused++;
        seat.viewer->say(errorMessage(e.what(), FocusMessage::TYPE, request.inputId));
    }
}

/// To who drives, from the meter's thread; takes the lock itself.
void View::effectCosts(EffectMeter::News&& news) {
    std::lock_guard lock(mutex_);
    if (ended_ || !costsAwaited_ || news.order != costsOrder_) return;
    Viewer& viewer = *seats_.front().viewer;
    if (news.costs || !news.failure.empty()) {
        costsAwaited_ = false;
        viewer.say(news.costs ? effectCostsReadyMessage(*news.costs) : effectCostsFailedMessage(news.failure));
    } else if (Clock::now() - costsAt_ >= PROGRESS_EVERY) {
        costsAt_ = Clock::now();
        viewer.say(effectCostsMeasuringMessage(news.share));
    }
}

void View::dropEffectCosts(const std::string& why) {
    meter_.drop();
    if (costsAwaited_ && !seats_.empty()) seats_.front().viewer->say(effectCostsFailedMessage(why));
    costsAwaited_ = false;
}

/// To who drives, from the meter's thread; takes the lock itself.
void View::accuracy(AccuracyMeter::News&& news) {
    const std::string ready = news.result ? accuracyReadyMessage(*news.result) : "";
    std::lock_guard lock(mutex_);
    if (ended_ || !accuracyAwaited_ || news.order != accuracyOrder_) return;
    Viewer& viewer = *seats_.front().viewer;
    if (news.result || !news.failure.empty()) {
        accuracyAwaited_ = false;
        viewer.say(news.result ? ready : accuracyFailedMessage(news.failure));
    } else if (Clock::now() - accuracyAt_ >= PROGRESS_EVERY) {
        accuracyAt_ = Clock::now();
        viewer.say(accuracyMeasuringMessage(news.share, news.what));
    }
}

void View::giveUpAccuracy() {
    accuracyMeter_.drop();
    if (accuracyAwaited_ && !seats_.empty()) seats_.front().viewer->say(accuracyGivenUpMessage());
    accuracyAwaited_ = false;
}

/// Of effect costs and accuracy, without a word.
void View::dropMeasurements() {
    meter_.drop();
    accuracyMeter_.drop();
    costsAwaited_ = accuracyAwaited_ = false;
}

void View::openFirstScene() {
    const std::vector<SceneRecipe> scenes = host_.scenes();
    if (!scenes.empty()) openScene(scenes.front().name);
}

void View::openScene(const std::string& name) {
    uint64_t order;
    std::shared_ptr<void> ticket;
    {
        std::lock_guard lock(mutex_);
        order = ++sceneOrder_;
        orderedName_ = name;
        sceneFailure_.clear();
        progressAt_ = {};
        std::swap(sceneTicket_, ticket);
    }
    ticket.reset();  // a load before, which nobody waits for now, takes no place from this one
    SceneListener listener;
    std::weak_ptr<View> self = weak_from_this();
    listener.progress = [=](const std::string& what, double share) {
        if (auto view = self.lock()) view->sceneProgress(order, what, share);
    };
    listener.ready = [=](std::shared_ptr<ResidentScene> scene) {
        if (auto view = self.lock()) view->sceneReady(order, std::move(scene));
    };
    listener.failed = [=](const std::string& why, std::exception_ptr) {
        if (auto view = self.lock()) view->sceneFailed(order, why);
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

void View::sceneProgress(uint64_t order, const std::string& what, double share) {
    std::lock_guard lock(mutex_);
    Clock::time_point now = Clock::now();
    if (order != sceneOrder_ || now - progressAt_ < PROGRESS_EVERY) return;
    progressAt_ = now;
    tell(sceneLoadingMessage(orderedName_, what, share));
}

void View::sceneReady(uint64_t order, std::shared_ptr<ResidentScene> scene) {
    std::lock_guard lock(mutex_);
    if (order != sceneOrder_ || ended_) return;
    scene_ = std::move(scene);
    sceneName_ = orderedName_;
    forgetPicture();
    for (const Seat& seat : seats_) {  // also where it is being made into bytes
        if (seat.viewer->dropPicture())
            seat.viewer->say(errorMessage("picture: the scene was changed before it was finished", "picture", std::nullopt));
    }
    dropEffectCosts("the scene was changed before they were measured");
    giveUpAccuracy();
    request_.camera = cameraFrom(startCamera(*scene_->scene, aspect()));
    request_.received = Clock::now();
    for (const Seat& seat : seats_) tellScene(*seat.viewer);
    bool visible = request_.resolution.x > 0;
    loop_.setScene(scene_, visible ? std::optional(request_) : std::nullopt);
}

void View::sceneFailed(uint64_t order, const std::string& why) {
    std::lock_guard lock(mutex_);
    if (order != sceneOrder_ || ended_) return;
    log().warn("viewer {}: {}", request_.viewer, why);
    sceneFailure_ = why;
    tell(sceneFailedMessage(orderedName_, why));
}

}  // namespace heliograph

#include "server/service/thumbnails.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/tone_map.h"
#include "server/render/frame_renderer.h"
#include "server/scene/framing.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uvec2 SIZE{160, 90};
constexpr uint32_t SAMPLES = 16;
constexpr int QUALITY = 85;

}  // namespace

std::string paintThumbnail(const ResidentScene& resident, const Settings& settings, Turns& turns, std::stop_token stop) {
    const Scene& scene = *resident.scene;
    const Camera camera = cameraFrom(startCamera(scene, double(SIZE.x) / SIZE.y));
    const FrameRequest request = frameRequest(scene, camera, settings, SIZE, 1);
    Film film;
    film.reset(SIZE, request.generation);
    PassRenderer passes(turns);
    PassFigures figures;
    ViewMemory view;
    while (figures.passes < SAMPLES)
        if (!passes.render({*resident.renderer, request, film, view, figures.passes, stop}, figures)) return {};
    std::vector<vec4> pixels;
    film.develop(pixels);
    DisplayImage image;
    ToneMap(shownExposure(film, scene, request), shownCurve(static_cast<ToneCurve>(settings.toneCurve), scene.fromFile))
        .apply(pixels, SIZE, image);
    std::vector<uint8_t> bytes;
    makeJpegEncoder(StripeThreads::own)->encode(image, QUALITY, bytes);
    return {bytes.begin(), bytes.end()};
}

Thumbnails::Thumbnails(const std::vector<std::string>& scenes, Open open, Paint paint, std::chrono::milliseconds failureLasts)
    : open_(std::move(open)), paint_(std::move(paint)), failureLasts_(failureLasts) {
    for (const std::string& scene : scenes) pictures_[scene].picture.state = Thumbnail::State::unasked;
    thread_ = std::jthread([this](std::stop_token stop) { run(std::move(stop)); });
}

Thumbnail Thumbnails::ask(std::string_view scene) {
    using State = Thumbnail::State;
    std::lock_guard lock(mutex_);
    const auto found = pictures_.find(scene);
    if (found == pictures_.end()) return {};
    State& state = found->second.picture.state;
    const auto now = std::chrono::steady_clock::now();
    if (state == State::failed && now - found->second.failed >= failureLasts_) state = State::unasked;
    if (const auto waits = std::ranges::find(wanted_, scene); waits != wanted_.end()) {
        std::rotate(wanted_.begin(), waits, waits + 1);
    } else if (state == State::unasked) {
        state = State::coming;
        wanted_.push_front(found->first);
        asked_.notify_all();
    }
    return found->second.picture;
}

void Thumbnails::giveWay() {
    std::shared_ptr<Attempt> attempt;
    {
        std::lock_guard lock(mutex_);
        attempt = attempt_;
    }
    if (!attempt) return;
    {
        std::lock_guard lock(attempt->mutex);
        attempt->gaveWay = true;
    }
    attempt->changed.notify_all();
}

void Thumbnails::run(std::stop_token stop) {
    while (const std::optional<std::string> scene = next(stop)) {
        Thumbnail made = make(*scene, stop);
        std::shared_ptr<Attempt> over;  // with a scene, perhaps, that takes long to let go of
        std::lock_guard lock(mutex_);
        over.swap(attempt_);
        pictures_[*scene] = {std::move(made), std::chrono::steady_clock::now()};
    }
}

/// The scene that was asked for last; nothing when `stop` was asked for.
std::optional<std::string> Thumbnails::next(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    asked_.wait(lock, stop, [&] { return !wanted_.empty(); });
    if (stop.stop_requested()) return {};
    std::string scene = std::move(wanted_.front());
    wanted_.pop_front();
    attempt_ = std::make_shared<Attempt>();
    return scene;
}

/// Unasked where it gave way.
Thumbnail Thumbnails::make(const std::string& scene, std::stop_token stop) {
    using State = Thumbnail::State;
    const std::shared_ptr<Attempt> attempt = attempt_;  // changed by this thread alone
    try {
        const std::shared_ptr<ResidentScene> resident = open(scene, *attempt, stop);
        if (!resident) return {State::unasked};
        std::string picture = paint_(*resident, stop);
        const State state = picture.empty() ? State::unasked : State::there;
        return {state, std::move(picture)};
    } catch (const std::exception& e) {
        log().warn("no small picture of {}: {}", scene, e.what());
        return {State::failed};
    }
}

/// Waits for the scene. Null where others go first or `stop` was asked for. Throws why it cannot be loaded.
std::shared_ptr<ResidentScene> Thumbnails::open(const std::string& scene, Attempt& attempt, std::stop_token stop) {
    const std::weak_ptr<Attempt> weak = attempt_;
    const auto tell = [weak](auto change) {
        const std::shared_ptr<Attempt> told = weak.lock();
        if (!told) return;
        {
            std::lock_guard lock(told->mutex);
            change(*told);
        }
        told->changed.notify_all();
    };
    SceneListener listener;
    listener.progress = [](const std::string&, double) {};
    listener.ready = [tell](std::shared_ptr<ResidentScene> ready) { tell([&](Attempt& a) { a.scene = std::move(ready); }); };
    listener.failed = [tell](const std::string& why, std::exception_ptr) { tell([&](Attempt& a) { a.failure = why; }); };
    std::shared_ptr<void> ticket;
    try {
        ticket = open_(scene, std::move(listener));
    } catch (const InputError&) {  // as many scenes are in use as there may be, or viewers wait for one
        return nullptr;
    }
    std::unique_lock lock(attempt.mutex);
    attempt.changed.wait(lock, stop, [&] { return attempt.scene || !attempt.failure.empty() || attempt.gaveWay; });
    if (!attempt.failure.empty()) throw std::runtime_error(attempt.failure);
    return std::move(attempt.scene);
}

}  // namespace heliograph

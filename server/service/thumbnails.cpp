#include "server/service/thumbnails.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/tone_map.h"
#include "server/render/frame_renderer.h"
#include "server/scene/framing.h"

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr uvec2 SIZE{160, 90};
constexpr uint32_t SAMPLES = 16;
constexpr int QUALITY = 85;
constexpr auto NO_ROOM_PAUSE = 1s;  // where no further scene may be opened

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

Thumbnails::Thumbnails(const std::vector<std::string>& scenes, Open open, Paint paint)
    : open_(std::move(open)), paint_(std::move(paint)) {
    for (const std::string& scene : scenes) pictures_[scene].state = Thumbnail::State::unasked;
    thread_ = std::jthread([this](std::stop_token stop) { run(std::move(stop)); });
}

Thumbnail Thumbnails::ask(std::string_view scene) {
    std::lock_guard lock(mutex_);
    const auto found = pictures_.find(scene);
    if (found == pictures_.end()) return {};
    if (found->second.state == Thumbnail::State::unasked) {
        found->second.state = Thumbnail::State::coming;
        wanted_.push_back(found->first);
        asked_.notify_all();
    }
    return found->second;
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
        Made made = make(*scene, stop);
        std::lock_guard lock(mutex_);
        attempt_.reset();
        if (made.outcome == Outcome::later) {
            wanted_.push_back(*scene);
            continue;
        }
        const auto state = made.outcome == Outcome::made ? Thumbnail::State::there : Thumbnail::State::failed;
        pictures_[*scene] = {state, std::move(made.picture)};
    }
}

/// The scene that has waited longest; nothing when `stop` was asked for.
std::optional<std::string> Thumbnails::next(std::stop_token stop) {
    std::unique_lock lock(mutex_);
    asked_.wait(lock, stop, [&] { return !wanted_.empty(); });
    if (stop.stop_requested()) return {};
    std::string scene = std::move(wanted_.front());
    wanted_.pop_front();
    attempt_ = std::make_shared<Attempt>();
    return scene;
}

Thumbnails::Made Thumbnails::make(const std::string& scene, std::stop_token stop) {
    const std::shared_ptr<Attempt> attempt = attempt_;  // changed by this thread alone
    try {
        const std::shared_ptr<ResidentScene> resident = open(scene, *attempt, stop);
        if (!resident) return {Outcome::later, {}};
        std::string picture = paint_(*resident, stop);
        return {picture.empty() ? Outcome::later : Outcome::made, std::move(picture)};
    } catch (const InputError&) {  // as many scenes are in use as there may be
        std::unique_lock lock(attempt->mutex);
        attempt->changed.wait_for(lock, stop, NO_ROOM_PAUSE, [] { return false; });
        return {Outcome::later, {}};
    } catch (const std::exception& e) {
        log().warn("no small picture of {}: {}", scene, e.what());
        return {Outcome::failed, {}};
    }
}

/// Waits for the scene. Null where it gave way or `stop` was asked for. Throws why it cannot be loaded.
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
    const std::shared_ptr<void> ticket = open_(scene, std::move(listener));
    std::unique_lock lock(attempt.mutex);
    attempt.changed.wait(lock, stop, [&] { return attempt.scene || !attempt.failure.empty() || attempt.gaveWay; });
    if (!attempt.failure.empty()) throw std::runtime_error(attempt.failure);
    return std::move(attempt.scene);
}

}  // namespace heliograph

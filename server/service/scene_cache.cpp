#include "server/service/scene_cache.h"

#include "server/request/effect_rules.h"
#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/log.h"

#include <algorithm>

namespace heliograph {

namespace {

/// Thrown from progress reports when nobody waits for the scene any more.
struct Abandoned {};

const std::string WAITING = "Waiting for another scene";
constexpr double OPENING_SHARE = 0.7;  // of the progress; the rest is the device's

}  // namespace

SceneCache::SceneCache(Opener opener, DeviceFactory makeDevice, Settings settings, Ended ended, size_t keep, size_t most)
    : opener_(std::move(opener)),
      makeDevice_(std::move(makeDevice)),
      settings_(settings),
      ended_(std::move(ended)),
      keep_(keep),
      most_(most) {
    thread_ = std::thread([this] { run(); });
}

SceneCache::~SceneCache() {
    stop();
    thread_.join();
}

void SceneCache::stop() {
    {
        std::lock_guard lock(mutex_);
        stopped_ = true;
    }
    changed_.notify_all();
}

std::shared_ptr<void> SceneCache::open(const std::string& name, SceneListener listener, Stay stay) {
    auto ticket = std::make_shared<Ticket>(Ticket{std::move(listener)});
    // Told before the ticket is in the queue: afterwards the loading thread might be ahead with `ready`.
    if (auto stand = standOf(name)) ticket->listener.progress(stand->first, stand->second);
    std::shared_ptr<ResidentScene> resident;
    {
        std::lock_guard lock(mutex_);
        auto found = std::find_if(residents_.begin(), residents_.end(), [&](const Resident& r) { return r.name == name; });
        auto loading = std::find_if(loads_.begin(), loads_.end(), [&](const Load& l) { return l.name == name; });
        if (found == residents_.end() && stay == Stay::no && awaitedBeside(name))
            throw InputError("scene.name", "viewers wait for another scene", "later");
        if (found != residents_.end()) {
            found->lastUse = ++uses_;
            resident = found->scene;
        } else if (loading != loads_.end()) {
            loading->tickets.push_back(ticket);
            loading->stays |= stay == Stay::yes;
        } else {
            dropAbandoned();
            checkRoom();
            loads_.push_back({name, {ticket}, WAITING, 0.0, stay == Stay::yes});
        }
    }
    if (resident) ticket->listener.ready(resident);
    else changed_.notify_all();
    return ticket;
}

/// What is done for the scene, and its share; nothing if it is resident. Throws InputError when it does not fit.
std::optional<std::pair<std::string, double>> SceneCache::standOf(const std::string& name) const {
    std::lock_guard lock(mutex_);
    for (const Resident& resident : residents_) {
        if (resident.name == name) return std::nullopt;
    }
    for (const Load& load : loads_) {
        if (load.name == name) return std::pair(load.what, load.share);
    }
    checkRoom();
    return std::pair(loads_.empty() ? "Opening " + name : WAITING, 0.0);
}

/// With the lock held: somebody waits for a scene that stays, of another name.
bool SceneCache::awaitedBeside(const std::string& name) const {
    return std::ranges::any_of(loads_, [&](const Load& l) { return l.stays && l.name != name && !l.abandoned(); });
}

bool SceneCache::awaited() const {
    std::lock_guard lock(mutex_);
    return awaitedBeside({});
}

/// With the lock held. Throws InputError when no further scene fits.
void SceneCache::checkRoom() const {
    auto used = std::count_if(residents_.begin(), residents_.end(), [](const Resident& r) { return r.scene.use_count() > 1; });
    const auto wanted = std::ranges::count_if(loads_, [](const Load& load) { return load.stays && !load.abandoned(); });
    if (static_cast<size_t>(used + wanted) < most_) return;
    throw InputError("scene.name", "viewers already look at " + std::to_string(used) + " other scenes",
                     "one of theirs, or later");
}

/// With the lock held: queued loads that nobody waits for any more go. The first one is in progress and ends by itself.
void SceneCache::dropAbandoned() {
    if (loads_.size() < 2) return;
    loads_.erase(std::remove_if(loads_.begin() + 1, loads_.end(), [](const Load& load) { return load.abandoned(); }),
                 loads_.end());
}

void SceneCache::pin(const std::string& name) {
    std::lock_guard lock(mutex_);
    for (Resident& resident : residents_) resident.pinned = resident.pinned || resident.name == name;
}

size_t SceneCache::loadCount() const {
    std::lock_guard lock(mutex_);
    return loads_.size();
}

size_t SceneCache::residentCount() const {
    std::lock_guard lock(mutex_);
    return residents_.size();
}

void SceneCache::run() {
    for (;;) {
        std::string name;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return stopped_ || !loads_.empty(); });
            if (stopped_) return;
            name = loads_.front().name;
        }
        load(name);
    }
}

/// Loads the first scene of the queue and tells everybody who waits for it.
void SceneCache::load(const std::string& name) {
    std::shared_ptr<ResidentScene> scene;
    std::string failure;
    std::exception_ptr error;
    StopWatch watch;
    try {
        scene = make(name);
        log().info("{}: {} triangles, ready after {:.2f} s", name, scene->scene->triangleCount(), watch.seconds());
    } catch (const Abandoned&) {
        log().info("{}: loading given up, nobody waits for it", name);
    } catch (const std::bad_alloc&) {
        failure = name + ": too large for this machine's memory";
        error = std::current_exception();
    } catch (const std::exception& e) {
        failure = e.what();
        error = std::current_exception();
    }
    std::vector<std::shared_ptr<Ticket>> tickets;
    {
        std::lock_guard lock(mutex_);
        tickets = waiting();
        // Somebody may have come while the load was being given up.
        if (!scene && failure.empty() && !tickets.empty() && !stopped_) return;
        const bool stays = loads_.front().stays;
        loads_.pop_front();
        if (scene && stays) residents_.push_back({name, scene, ++uses_});
    }
    ended_(scene ? "ready" : failure.empty() ? "abandoned" : "failed");
    for (const auto& ticket : tickets) {
        if (scene) ticket->listener.ready(scene);
        else if (!failure.empty()) ticket->listener.failed(failure, error);
    }
    tickets.clear();
    if (scene) forgetOldest();
}

/// Lets go of the scenes that were not looked at for longest.
void SceneCache::forgetOldest() {
    std::vector<Resident> dropped;  // destroyed after the lock: that takes long
    std::lock_guard lock(mutex_);
    while (residents_.size() > keep_) {
        auto oldest = residents_.end();
        for (auto r = residents_.begin(); r != residents_.end(); ++r) {
            const bool idle = !r->pinned && r->scene.use_count() == 1;
            if (idle && (oldest == residents_.end() || r->lastUse < oldest->lastUse)) oldest = r;
        }
        if (oldest == residents_.end()) break;
        dropped.push_back(std::move(*oldest));
        residents_.erase(oldest);
    }
}

std::shared_ptr<ResidentScene> SceneCache::make(const std::string& name) {
    progress("Opening " + name, 0.0);
    auto resident = std::make_shared<ResidentScene>();
    resident->scene = opener_(name, [&](const std::string& what, double share) { progress(what, OPENING_SHARE * share); });
    resident->reasons = explainEffects(*resident->scene);
    resident->effects = possibleEffects(resident->reasons);
    resident->renderer = makeDevice_();
    resident->renderer->load(resident->scene, settings_, [&](const std::string& what, double share) {
        progress(what, OPENING_SHARE + (1.0 - OPENING_SHARE) * share);
    });
    return resident;
}

std::vector<std::shared_ptr<SceneCache::Ticket>> SceneCache::waiting() const {
    std::vector<std::shared_ptr<Ticket>> tickets;
    for (const auto& weak : loads_.front().tickets) {
        if (auto ticket = weak.lock()) tickets.push_back(std::move(ticket));
    }
    return tickets;
}

void SceneCache::progress(const std::string& what, double share) {
    std::vector<std::shared_ptr<Ticket>> tickets;
    {
        std::lock_guard lock(mutex_);
        if (stopped_) throw Abandoned();
        tickets = waiting();
        loads_.front().what = what;
        loads_.front().share = share;
    }
    if (tickets.empty()) throw Abandoned();
    for (const auto& ticket : tickets) ticket->listener.progress(what, share);
}

}  // namespace heliograph

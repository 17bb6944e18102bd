#include "server/render/device_set.h"

#include "server/base/text.h"
#include "server/base/log.h"
#include "server/render/device_slot.h"
#include "server/request/device_rows.h"

#include <algorithm>
#include <map>
#include <set>
#include <system_error>
#include <stdexcept>

namespace heliograph {

namespace {

const std::string HYBRID = "hybrid";
const std::string OWES = "still owes a batch of an earlier frame";
const std::string NO_MEMORY = "no memory for this frame";
constexpr double LATE = 0.05;  // seconds

class DeviceSet : public Renderer {
public:
    DeviceSet(DeviceOffer offer, TileScheduler& scheduler, DeviceSetOptions options)
        : offer_(std::move(offer)), scheduler_(scheduler), options_(std::move(options)) {}

    DeviceInfo info() const override { return infoOf(first_); }
    DeviceInfo infoFor(const Settings& settings) const override { return infoOf(offer_.nameOf(settings)); }

    void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) override {
        {
            std::lock_guard lock(mutex_);
            entries_.clear();
            memory_ = {};
            scene_ = std::move(scene);
            first_ = offer_.nameOf(settings);
        }
        if (!isTeam(first_)) {
            usable(first_, settings, progress);
            if (hasFallback(first_) && !options_.patient)
                background_.run(scheduler_.pool(), [this, settings] { loadFallback(settings); });
            return;
        }
        bool any = false;
        for (const std::string& name : membersOf(first_, true)) {
            if (switchedOff(name, settings) || (any && !options_.patient)) continue;
            any |= loaded(name, settings, progress) != nullptr;
        }
        if (!any) throw std::runtime_error(first_ + ": " + whyNobody(first_, settings, {}));
    }

    void prepare(const Settings& settings) override {
        const std::string name = offer_.nameOf(settings);
        if (!isTeam(name)) usable(name, settings, {})->prepare(settings);
    }

    ScheduleReport render(const FrameRequest& request, std::span<const Tile> tiles, ViewMemory& view, const TileSink& sink,
                          std::stop_token stop) override {
        const std::string name = offer_.nameOf(request.settings);
        ScheduleReport report;
        std::vector<Tile> missing;
        std::set<std::string> full;  // had no memory for this frame: others make it, and everybody else's goes on
        while (!tiles.empty() && !stop.stop_requested()) {
            ScheduleResult result = scheduler_.render(request, tiles, team(name, request, full), memory_, view, sink, stop);
            report.append(result.report);
            for (const DeviceFailure& failure : result.failures) {
                memory_.rates.forget(failure.device);
                if (!isTeam(name) && !hasFallback(name)) throw std::runtime_error(failure.why);
                if (failure.ofMemory) full.insert(failure.device), noteFull(failure, request.resolution);
                else setAside(failure.device, failure.why);
            }
            missing = std::move(result.missing);
            tiles = missing;
        }
        return report;
    }

    bool denoise(const Settings& settings, DenoiseJob& job) override {
        const std::string name = offer_.nameOf(settings);
        if (isTeam(name)) return false;
        const std::shared_ptr<Device> device = entry(name)->ready();
        return device && device->denoise(job);
    }

    DepthAnswer depthAlong(const ViewRay& ray) override {
        std::vector<std::shared_ptr<DeviceSlot>> entries;
        {
            std::lock_guard lock(mutex_);
            for (const auto& [name, slot] : entries_) entries.push_back(slot);
        }
        for (const std::shared_ptr<DeviceSlot>& slot : entries) {
            std::shared_ptr<Device> device = slot->ready();
            DepthAnswer answer = device ? device->depthAlong(ray) : DepthAnswer{};
            if (answer.known) return answer;
        }
        return {};
    }

private:
    std::shared_ptr<DeviceSlot> entry(const std::string& name) const {
        std::lock_guard lock(mutex_);
        std::shared_ptr<DeviceSlot>& slot = entries_[name];
        if (!slot) slot = std::make_shared<DeviceSlot>(name);
        return slot;
    }

    static bool isTeam(std::string_view name) { return name == HYBRID || name == POOL || name == POOLED; }

    /// The devices of a team, this machine's first. `standIn`: with the one that stands in for nodes.
    std::vector<std::string> membersOf(std::string_view team, bool standIn = false) const {
        std::vector<std::string> members;
        if (team == HYBRID) members = offer_.team;
        else if (team == POOLED) members = {offer_.own};
        else if (standIn) members = {offer_.fallback};
        if (offer_.nodes) std::ranges::move(offer_.nodes(), std::back_inserter(members));
        return members;
    }

    /// Nodes that have left are forgotten.
    void forgetNodes(const std::vector<std::string>& members) {
        if (!offer_.nodes) return;
        std::vector<std::shared_ptr<DeviceSlot>> gone;  // end without the lock
        std::lock_guard lock(mutex_);
        std::erase_if(entries_, [&](const auto& entry) {
            const DeviceRow* row = deviceRow(entry.first);
            if (!row || row->kind != DeviceKind::node || std::ranges::find(members, entry.first) != members.end()) return false;
            memory_.rates.forget(entry.first);
            gone.push_back(entry.second);
            return true;
        });
    }

    /// Of the device, or of its fallback once that has taken over.
    DeviceInfo infoOf(const std::string& name) const {
        DeviceInfo info;
        if (!isTeam(name)) {
            std::shared_ptr<Device> device = entry(name)->ready();
            if (!device && hasFallback(name) && !entry(name)->failure().empty()) device = entry(offer_.fallback)->ready();
            return device ? device->info() : info;
        }
        info.name = name == HYBRID ? HYBRID : std::string(POOL);
        info.workers = 0;
        for (const std::string& member : membersOf(name, true)) {
            std::shared_ptr<Device> device = entry(member)->ready();
            if (!device) continue;
            info.details += (info.details.empty() ? "" : " + ") + device->info().name;
            info.workers += device->info().workers;
        }
        info.workers = std::max(info.workers, 1u);
        return info;
    }

    bool hasFallback(const std::string& name) const {
        const DeviceRow* row = deviceRow(name);
        return row && !row->standIn.empty() && !offer_.fallback.empty();
    }

    /// The device with the scene. Devices do not wait for each other's loading. Throws what it throws.
    std::shared_ptr<Device> loadNow(const std::shared_ptr<DeviceSlot>& entry, const Settings& settings,
                                    const Progress& progress) {
        std::lock_guard loading(entry->loading);
        if (std::shared_ptr<Device> device = entry->ready()) return device;
        std::shared_ptr<const Scene> scene;
        {
            std::lock_guard lock(mutex_);
            scene = scene_;
        }
        log().debug("starting {}", entry->name);
        std::shared_ptr<Device> device = offer_.make(entry->name);
        device->load(scene, settings, progress);
        {
            std::lock_guard lock(entry->mutex);
            entry->device = device;
        }
        if (!options_.patient)
            background_.run(scheduler_.pool(), [this, name = entry->name, device] { standBy(name, *device); });
        return device;
    }

    /// Whether the device has the scene and what it needs for such requests; waits for both. For where nobody else could render
    /// meanwhile.
    bool warmedUp(const std::string& name, const FrameRequest& request) {
        const std::shared_ptr<Device> device = loaded(name, request.settings, {});
        if (!device) return false;
        try {
            if (device->warmth(request) == Warmth::cold) device->warmUp(request);
        } catch (const std::exception& error) {
            setAside(name, error.what());
            return false;
        }
        const std::shared_ptr<DeviceSlot> slot = entry(name);
        std::lock_guard lock(slot->mutex);
        slot->blocked = false;  // it is warm, though whoever began to warm it may not have said so yet
        return true;
    }

    void standBy(const std::string& name, Device& device) {
        try {
            device.standBy();
        } catch (const std::exception& error) {
            log().warn("{} cannot stand by for other effects: {}", name, error.what());  // it still renders
        }
    }

    /// The same, or null where it is or was set aside for failing.
    std::shared_ptr<Device> loaded(const std::string& name, const Settings& settings, const Progress& progress) {
        std::shared_ptr<DeviceSlot> member = entry(name);
        if (!member->failure().empty()) return nullptr;
        try {
            return loadNow(member, settings, progress);
        } catch (const std::exception& error) {
            setAside(name, error.what());
            return nullptr;
        }
    }

    /// What renders for that name: the device, or its fallback.
    std::shared_ptr<Device> usable(const std::string& name, const Settings& settings, const Progress& progress) {
        if (!hasFallback(name)) return loadNow(entry(name), settings, progress);
        std::shared_ptr<Device> device = loaded(name, settings, progress);
        return device ? device : loadNow(entry(offer_.fallback), settings, progress);
    }

    /// So that it can take over within a frame's time. If that fails, it is tried again when it is needed.
    void loadFallback(const Settings& settings) {
        try {
            loadNow(entry(offer_.fallback), settings, {});
        } catch (const std::exception& error) {
            log().warn("{} cannot stand by: {}", offer_.fallback, error.what());
        }
    }

    void setAside(const std::string& name, const std::string& why) {
        std::shared_ptr<DeviceSlot> failed = entry(name);
        {
            std::lock_guard lock(failed->mutex);
            if (!failed->aside.empty()) return;
            failed->aside = why.empty() ? "failed" : why;
            failed->device = nullptr;
        }
        std::string text = "device " + name + " was set aside: " + why + "; ";
        text += hasFallback(name) ? offer_.fallback + " goes on" : "the others go on";
        log().warn("{}", text);
        if (options_.notice) options_.notice(name, text);
    }

    void noteFull(const DeviceFailure& failure, uvec2 size) {
        const auto level = std::exchange(toldOfMemory_, true) ? spdlog::level::debug : spdlog::level::warn;
        log().log(level, "{}: {} ({} x {} pixels); others make it", failure.device, failure.why, size.x, size.y);
    }

    /// Who may render for that name now. Waits for the first that is ready. Throws when there is nobody.
    std::vector<Candidate> team(const std::string& name, const FrameRequest& request, const std::set<std::string>& full) {
        if (!isTeam(name)) return loner(name, request, full);
        auto can = [](const Candidate& c) { return c.blocked.empty(); };
        std::vector<std::string> members = membersOf(name);
        forgetNodes(members);
        std::vector<Candidate> team = candidates(members, request, full);
        if (name == POOL && std::ranges::none_of(team, can)) {
            members = membersOf(name, true);
            team = candidates(members, request, full);
        }
        if (std::ranges::none_of(team, can)) {
            for (const std::string& member : members) {
                if (switchedOff(member, request.settings) || full.contains(member)) continue;
                if (warmedUp(member, request)) break;
            }
            team = candidates(members, request, full);
        }
        if (std::ranges::none_of(team, can)) throw std::runtime_error(name + ": " + whyNobody(name, request.settings, full));
        return team;
    }

    /// The device of that name. While it compiles for these effects or when it has failed, its fallback, which makes the same picture.
    std::vector<Candidate> loner(const std::string& name, const FrameRequest& request, const std::set<std::string>& full) {
        std::shared_ptr<DeviceSlot> slot = entry(name);
        const std::shared_ptr<Device> device = usable(name, request.settings, {});
        if (!hasFallback(name)) return {candidateOf(*slot, device, request.settings)};
        std::vector<Candidate> team;
        std::string why = slot->failure();
        if (!why.empty()) why = "set aside: " + why;
        else if (full.contains(name)) why = NO_MEMORY;
        else if (!options_.patient) why = getReady(slot, request, true);
        if (why.empty()) return {candidateOf(*slot, device, request.settings)};
        team.push_back(candidateOf(*slot, slot->ready(), request.settings));
        team.back().blocked = why;
        if (full.contains(offer_.fallback)) throw std::runtime_error(offer_.fallback + ": " + NO_MEMORY);
        const std::shared_ptr<Device> fallback = loadNow(entry(offer_.fallback), request.settings, {});
        team.push_back(candidateOf(*entry(offer_.fallback), fallback, request.settings));
        return team;
    }

    Candidate candidateOf(DeviceSlot& slot, std::shared_ptr<Device> device, const Settings& settings) const {
        Candidate c;
        c.info.name = slot.name;
        if (device) c.info = device->infoFor(settings);
        c.device = std::move(device);
        c.inFlight = slot.inFlight;
        c.forced = options_.forced;
        return c;
    }

    /// Why no device is left.
    std::string whyNobody(std::string_view team, const Settings& settings, const std::set<std::string>& full) {
        std::vector<std::string> reasons;
        for (const std::string& name : membersOf(team, true)) {
            std::string why = switchedOff(name, settings) ? "switched off" : entry(name)->failure();
            if (why.empty() && full.contains(name)) why = NO_MEMORY;
            if (why.empty()) why = entry(name)->ready() ? "did not deliver" : "is not ready";
            reasons.push_back(name + ": " + why);
        }
        return reasons.empty() ? "no device here" : joined(reasons, "; ");
    }

    std::vector<Candidate> candidates(const std::vector<std::string>& members, const FrameRequest& request,
                                      const std::set<std::string>& full) {
        std::vector<Candidate> team;
        for (const std::string& name : members) {
            std::shared_ptr<DeviceSlot> member = entry(name);
            Candidate c = candidateOf(*member, member->ready(), request.settings);
            if (switchedOff(name, request.settings)) c.blocked = "switched off";
            else if (std::string why = member->failure(); !why.empty()) c.blocked = "set aside: " + why;
            else if (full.contains(name)) c.blocked = NO_MEMORY;
            else if (member->owes(LATE)) c.blocked = OWES;
            else c.blocked = getReady(member, request);
            if (c.blocked.empty()) c = candidateOf(*member, member->ready(), request.settings);
            team.push_back(std::move(c));
        }
        // Rather wait for one that stalls than for nobody.
        if (std::ranges::none_of(team, [](const Candidate& c) { return c.blocked.empty(); })) {
            for (Candidate& c : team) {
                if (c.blocked == OWES && c.device) c.blocked.clear();
            }
        }
        return team;
    }

    /// Starts what a device needs before it can take part, or to be faster; returns what it waits for, or nothing.
    /// `hasFallback`: somebody renders for it meanwhile.
    std::string getReady(const std::shared_ptr<DeviceSlot>& member, const FrameRequest& request, bool hasFallback = false) {
        bool serves;
        {
            std::lock_guard lock(member->mutex);
            const Warmth warmth = member->device ? member->device->warmth(request) : Warmth::cold;
            if (warmth == Warmth::warm) return member->blocked ? "is compiling for other effects" : "";
            serves = warmth == Warmth::generic;
            if (serves && member->busy) return {};
            if (member->busy) return member->device ? "is compiling for these effects" : "is being given the scene";
            member->busy = true;
            member->blocked = !serves && !options_.patient;
        }
        auto work = [this, member, wanted = request] {
            if (std::shared_ptr<Device> device = loaded(member->name, wanted.settings, {})) {
                try {
                    device->warmUp(wanted);
                } catch (const std::exception& error) {
                    setAside(member->name, error.what());
                }
            }
            std::lock_guard lock(member->mutex);
            member->busy = member->blocked = false;
        };
        // The device that is there already has nothing to wait for, unless others serve while it compiles.
        const bool there = member->ready() && !offer_.team.empty() && member->name == offer_.team.front();
        if (options_.patient || (there && !hasFallback)) {
            work();
            std::string why = member->failure();
            return why.empty() ? "" : "set aside: " + why;
        }
        background_.run(scheduler_.pool(), work);
        return serves ? "" : "is being made ready";
    }

    /// Tasks that use the set; it does not end before them.
    class Background {
    public:
        ~Background() {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return running_ == 0; });
        }
        void run(WorkerPool& pool, std::function<void()> task) {
            {
                std::lock_guard lock(mutex_);
                running_++;
            }
            const std::function<void()> counted = [this, task = std::move(task)] {
                task();
                std::lock_guard lock(mutex_);
                running_--;
                changed_.notify_all();
            };
            try {
                pool.run(counted);
            } catch (const std::system_error&) {
                counted();  // no thread to be had: who asked for it does it
            }
        }

    private:
        std::mutex mutex_;
        std::condition_variable changed_;
        uint32_t running_ = 0;
    };

    const DeviceOffer offer_;
    TileScheduler& scheduler_;
    const DeviceSetOptions options_;
    mutable std::mutex mutex_;
    std::string first_;
    std::shared_ptr<const Scene> scene_;
    mutable std::map<std::string, std::shared_ptr<DeviceSlot>> entries_;
    ScheduleMemory memory_;      // used by the frame in progress alone: frames take turns
    bool toldOfMemory_ = false;  // by the frame in progress alone
    Background background_;      // ends first
};

}  // namespace

std::unique_ptr<Renderer> makeDeviceSet(DeviceOffer offer, TileScheduler& scheduler, DeviceSetOptions options) {
    return std::make_unique<DeviceSet>(std::move(offer), scheduler, std::move(options));
}

}  // namespace heliograph

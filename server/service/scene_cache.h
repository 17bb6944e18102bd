#pragma once
// The scenes that the server holds ready, each on a device of its own. Loading happens on one thread in the background, so
// viewers of other scenes are not disturbed; a load that nobody waits for any more is given up.

#include "server/stream/session_host.h"

#include <deque>
#include <algorithm>

namespace heliograph {

class SceneCache {
public:
    using Opener = std::function<std::shared_ptr<const Scene>(const std::string& name, const Progress& progress)>;
    using Ended = std::function<void(const char* outcome)>;
    using DeviceFactory = std::function<std::unique_ptr<Renderer>()>;

    /// Whether the scene stays when nobody looks at it any more. One that is loaded without staying takes nobody's place, and is
    /// refused while somebody waits for another one.
    enum class Stay { no, yes };

    /// `settings` for the devices' load. At most `keep` scenes stay where they are not looked at; with `most` in use or on
    /// their way a further one is refused.
    /// `ended` is told of each load: ready, failed or abandoned.
    SceneCache(
        Opener opener, DeviceFactory makeDevice, Settings settings, Ended ended = [](const char*) {}, size_t keep = 3,
        size_t most = 8);
    /// Gives up the load in progress, at its next report of progress.
    ~SceneCache();

    /// Calls the listener at once if the scene is resident, else later from the loading thread; where the load stands is
    /// told at once. The load is given up when
    /// all its tickets are gone. Throws InputError when `most` scenes are in use.
    std::shared_ptr<void> open(const std::string& name, SceneListener listener, Stay stay = Stay::yes);
    /// A resident scene stays from now on, looked at or not. It is in use only while someone holds it.
    void pin(const std::string& name);
    /// Somebody waits for a scene that stays.
    bool awaited() const;
    size_t residentCount() const;
    /// Loads in progress or waiting.
    size_t loadCount() const;
    /// Gives up the load in progress and takes no more.
    void stop();

private:
    struct Ticket {
        SceneListener listener;
    };
    struct Load {
        std::string name;
        std::vector<std::weak_ptr<Ticket>> tickets;
        std::string what;  // the last report
        double share = 0.0;
        bool stays = false;  // somebody wanted that
        /// Nobody waits for it any more.
        bool abandoned() const {
            return std::ranges::all_of(tickets, [](const std::weak_ptr<Ticket>& ticket) { return ticket.expired(); });
        }
    };
    struct Resident {
        std::string name;
        std::shared_ptr<ResidentScene> scene;
        uint64_t lastUse = 0;
        bool pinned = false;
    };

    std::optional<std::pair<std::string, double>> standOf(const std::string& name) const;
    bool awaitedBeside(const std::string& name) const;
    void checkRoom() const;
    void dropAbandoned();
    void run();
    void load(const std::string& name);
    std::shared_ptr<ResidentScene> make(const std::string& name);
    void forgetOldest();
    void progress(const std::string& what, double share);
    std::vector<std::shared_ptr<Ticket>> waiting() const;

    const Opener opener_;
    const DeviceFactory makeDevice_;
    const Settings settings_;
    const Ended ended_;
    const size_t keep_, most_;

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<Resident> residents_;
    std::deque<Load> loads_;  // the first one is in progress
    uint64_t uses_ = 0;
    bool stopped_ = false;
    std::thread thread_;
};

}  // namespace heliograph

#pragma once
// The server put together: scenes, viewers and the port.

#include "server/service/kept_views.h"
#include "server/service/picture_memory.h"
#include "server/service/scene_cache.h"
#include "server/service/thumbnails.h"
#include "server/base/log.h"
#include "server/net/guard/rate_limit.h"
#include "server/net/socket_server.h"
#include "server/operations/liveness.h"
#include "server/operations/metrics_text.h"
#include "server/operations/readiness.h"
#include "server/render/device_set.h"
#include "server/stream/session.h"

namespace heliograph {

struct ServiceOptions {
    SocketOptions socket;
    std::vector<SceneRecipe> scenes;  // on offer; the first is where viewers start
    SceneCache::Opener openScene;
    std::function<bool(const std::string&)> opensToo;    // names beside `scenes`, of which nobody is told; may be empty
    DeviceOffer devices;                                 // viewers choose between them
    std::function<nlohmann::ordered_json()> poolReport;  // what viewers are told of render nodes; empty: there is no pool
    std::function<PoolState()> poolState;                // for /metrics; empty: there is no pool
    Settings defaults;                                   // of every viewer
    uint64_t pictureBytes = 2ull << 30;                  // memory for the pictures of all viewers (film_shares.h)
    SettingCaps caps;                                    // of every viewer
    double leastRate = 0.0;             // frames a second; a newcomer who would see fewer is refused (admission.h)
    std::chrono::seconds watchdog{20};  // a part that has not moved for so long is stuck
    std::chrono::milliseconds keepViews = KEPT_VIEW;  // of who has gone with a broken line, until it comes back
};

/// What can be changed while it runs.
struct ServiceReload {
    SocketAccess access;
    Settings defaults;  // of viewers that come later
    std::chrono::seconds watchdog{20};
};

class Service : private SessionHost, private SocketHandler {
public:
    /// Binds the port. Throws InputError.
    explicit Service(ServiceOptions options);
    /// Ends everything: viewers are told, passes in flight end at the next tile.
    ~Service();

    /// Begins to serve and to load the first scene. `done` is called once from another thread, with why it failed or null.
    void start(std::function<void(std::exception_ptr failure)> done);
    /// Throws InputError, and changes nothing, as SocketServer::reload.
    void reload(const ServiceReload& reload);
    /// The beginning of the end: viewers are told, nobody is let in, and inputs are not taken any more. `atMost`: until the
    /// destructor comes.
    void drain(std::chrono::milliseconds atMost);
    /// Every viewer has the answer to its last input.
    bool drained() const;
    /// Parts that have not moved for as long as the option says.
    std::vector<std::string> stuck() const { return liveness_.stuck(Liveness::Clock::now(), std::chrono::seconds(watchdog_)); }
    /// What is being done for viewers and has not ended for as long as the option says: "viewer 7, render".
    std::vector<std::string> stuckViews() const;
    /// Viewers that have gone and loads of scenes that are over: after each there is memory to give back.
    uint64_t leftCount() const { return left_; }
    std::string url() const { return socket_.url(); }
    int port() const { return socket_.port(); }

private:
    // SessionHost
    std::vector<SceneRecipe> scenes() const override { return options_.scenes; }
    bool opensToo(const std::string& name) const override { return options_.opensToo && options_.opensToo(name); }
    std::vector<std::string> devices() const override { return options_.devices.words; }
    std::shared_ptr<void> openScene(const std::string& name, SceneListener listener) override;
    uint64_t grantPixels(uint32_t view, uint64_t wanted) override;
    std::shared_ptr<void> look(uint32_t view) override;
    void viewEnded(std::shared_ptr<View> view) override;
    void viewLeft(std::shared_ptr<View> view) override;
    size_t viewerCount() const override;
    uint64_t residentBytes() const override { return resident_; }
    Views& views() override { return views_; }
    Turns& turns() override { return scheduler_.turns(); }
    Metrics& metrics() override { return metrics_; }
    nlohmann::ordered_json poolReport() const override { return options_.poolReport ? options_.poolReport() : nullptr; }
    // SocketHandler
    std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket> socket, bool authorized) override;
    void closed(std::shared_ptr<ViewerPeer> peer, std::optional<CloseCode> code) override;
    void guestClosed(CloseCode code) override { metrics_.closes.add(closeReason(code)); }
    void refused(unsigned status, const std::string& why) override;
    std::string metricsText() override;
    Readiness readiness() override;
    std::optional<NoRoom> mayEnter() override;
    Thumbnail thumbnail(std::string_view scene) override;
    AdminAnswer admin(std::string_view method, std::string_view path) override;
    bool ending() override { return ending_; }
    void turned() override { socketPart_.beat(); }

    std::vector<std::shared_ptr<Session>> sessions() const;
    std::optional<NoRoom> tooCrowded() const;
    nlohmann::ordered_json viewersJson() const;
    bool disconnect(uint32_t viewer);
    uint64_t grant(uint32_t view, uint64_t wanted);
    bool tryLook(uint32_t view);
    bool endViews(KeptViews::Views views);
    bool endKeptViews();
    void letViewersGoFirst();
    void openForAdmin(const std::string& name);
    LogLevel lineLevel();
    void attend(std::stop_token stop);
    void reap(std::stop_token stop);
    void deviceFailed(const std::string& device, const std::string& what);
    std::optional<NotReady> unready() const;
    void tellEverybody(const std::string& what);

    const ServiceOptions options_;                              // as at the start
    std::atomic<int64_t> watchdog_{options_.watchdog.count()};  // seconds
    TileScheduler scheduler_;
    Metrics metrics_;
    Views views_;

    mutable std::mutex mutex_;  // of all below up to lastViewer_
    std::condition_variable_any someEnded_;
    std::vector<std::shared_ptr<Session>> sessions_;
    std::vector<std::shared_ptr<void>>
        ended_;  // sessions and views to be destroyed by the reaper, which waits for their threads
    PictureMemory memory_{options_.pictureBytes};
    KeptViews keptViews_;
    ServiceReload current_{options_.socket, options_.defaults, options_.watchdog};
    struct Entry {
        std::shared_ptr<ViewerSocket> socket;
        std::chrono::steady_clock::time_point since;
    };
    std::map<uint32_t, Entry> entries_;  // by viewer
    uint32_t lastViewer_ = 0;
    RateLimit lines_{10.0, 100.0};  // of the log; the socket's thread alone
    bool startThere_ = false;       // stays in memory, so that a newcomer always sees something at once
    std::string startFailure_;

    std::atomic<bool> ending_{false};
    std::atomic<bool> closed_{false};  // by an admin: those inside stay
    std::atomic<uint64_t> left_{0};    // viewers and loads that are over
    std::atomic<uint64_t> resident_{heliograph::residentBytes()};
    Liveness liveness_;
    Liveness::Part& socketPart_ = liveness_.add("socket");
    Liveness::Part& attendantPart_ = liveness_.add("attendant");

    SceneCache cache_;                  // after the sessions: its devices tell them of faults for as long as they live
    std::shared_ptr<void> firstScene_;  // ticket
    std::map<std::string, std::shared_ptr<void>> adminScenes_;  // tickets; the socket's thread alone
    Thumbnails thumbnails_;
    SocketServer socket_;
    std::jthread attendant_, reaper_;
};

}  // namespace heliograph

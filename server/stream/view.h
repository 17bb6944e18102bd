#pragma once
// One view of one scene, and all who look at it: the request (camera, settings, size), the scene, the loop that renders it, the
// run along a path, focus, pictures, effect costs and accuracy. The viewer who came first drives; the others watch: they are sent the same
// frames, each as fast as it takes them, at its own quality and under input ids of its own. When the driver leaves, the one who
// came next drives; when the last one leaves, the view ends.

#include "server/loop/frame_loop.h"
#include "server/loop/effect_meter.h"
#include "server/lab/view/accuracy_meter.h"
#include "server/request/setting_caps.h"
#include "server/pace/admission.h"
#include "server/stream/audience.h"
#include "server/stream/session_host.h"
#include "server/viewer/viewer.h"

namespace heliograph {

/// By which a viewer who comes back proves to be who held a seat before.
struct SeatKeys {
    std::string own;     // of the seat it is given now, told to that viewer alone
    std::string former;  // of the seat it had; empty: none
};

/// Safe from all threads. What a viewer asks for throws InputError where it is wrong, and where the viewer does not drive; nothing
/// has changed then. Viewers must have left before they are destroyed.
class View : public std::enable_shared_from_this<View>, private FrameReceiver {
public:
    using Clock = std::chrono::steady_clock;

    /// `number`: counts the server's views. `id`: what others have to know to watch it.
    View(SessionHost& host, uint32_t number, std::string id, const Settings& defaults, const SettingCaps& caps);
    /// Waits for the threads of the view.
    ~View();

    uint32_t number() const { return number_; }
    const std::string& id() const { return id_; }

    /// The viewer looks from now on, and is told what there is to see; the first one drives. `inputId`: of its message that asked
    /// for it, which every frame that it is given answers; without one it has just connected.
    /// Who holds the former key in `keys` comes back: it takes the seat it had, if it still has one.
    void join(Viewer& viewer, std::optional<uint32_t> inputId, const SeatKeys& keys = {});
    /// The viewer is given nothing more. True for the last one: nothing is rendered until somebody comes.
    bool leave(Viewer& viewer);
    /// Nobody may come any more. False where somebody looks at it.
    bool end();
    /// It asks to look at the view that it looks at already.
    void stay(const Viewer& viewer, uint32_t inputId);
    bool drives(const Viewer& viewer) const;
    /// The viewer may take another frame now.
    void drained(const Viewer& viewer);

    void handle(const Viewer& viewer, const CameraMessage& message);
    void handle(Viewer& viewer, const SettingsMessage& message);
    void handle(Viewer& viewer, const ResolutionMessage& message);
    void handle(const Viewer& viewer, const SceneMessage& message);
    void handle(Viewer& viewer, const PictureMessage& message);
    void handle(const Viewer& viewer, const PathMessage& message);
    void handle(Viewer& viewer, const EffectCostsMessage& message);
    void handle(Viewer& viewer, const AccuracyMessage& message);
    void handle(const Viewer& viewer, const FocusMessage& message);
    void handle(Viewer& viewer, const DriveMessage& message);
    void handle(const Viewer& viewer, const PickMessage& message);
    /// Begins to open the first scene on offer.
    void openFirstScene();

    /// The viewer's figures over the last `seconds`; nothing while there is no scene.
    std::optional<ViewerStats> stats(Viewer& viewer, double seconds) const;
    /// Whether there is something for `stats` to tell to one who was last told of so many watchers.
    bool hasNews(const Viewer& viewer, size_t watchersTold) const;
    /// What the view has used of the device lately, told of who drives alone: it is rendered once.
    std::optional<ViewerLoad> load(const Viewer& viewer, Clock::time_point now) const;
    /// What the view is at for who drives it, and what is made into bytes for the viewer.
    std::vector<RunningStage> stages(const Viewer& viewer) const;
    /// As FrameLoop::retry.
    bool retry() { return loop_.retry(); }
    bool awake() const { return loop_.awake(); }
    /// The viewer has been given a frame that shows its last input, or there is none to come.
    bool answered(const Viewer& viewer) const;

private:
    struct Seat {
        Viewer* viewer;
        std::string key;
        uint32_t inputId = 0;  // newest one that every frame shows
        uint32_t quality = 80;
        Given given;
        std::weak_ptr<const Film> film;      // of the frame given last
        std::optional<uint32_t> asked = {};  // to drive, with this input id; not yet answered
    };

    // FrameReceiver
    Readiness readiness() override;
    uint32_t coarser() override;
    void take(FinishedFrame&& frame) override;
    void pathEnded(const FrameSummary& result) override;
    void focused(const FocusRequest& request, const DepthAnswer& answer) override;
    void picked(const PickRequest& request, const DepthAnswer& answer, const Scene& scene) override;
    void failed(const std::string& what) override;

    // All below but the opening of scenes: with the lock held.
    size_t watchers() const { return seats_.empty() ? 0 : seats_.size() - 1; }
    Seat* seatOf(uint32_t viewer);
    const Seat* seatOf(uint32_t viewer) const { return const_cast<View*>(this)->seatOf(viewer); }
    Seat& driver(const Viewer& viewer, const char* about);
    size_t vacate(std::string_view key);
    void promote(Seat& seat, std::optional<uint32_t> inputId = {});
    void ask(Seat& seat, uint32_t inputId);
    void handOver(Seat& next, uint32_t inputId);
    void forgetNewest();
    void give(Seat& seat);
    size_t filmsOut() const;
    void forgetPicture();
    void tell(const std::string& text);
    void tellSettings(const Seat& seat, std::optional<uint32_t> inputId) const;
    void tellScene(Viewer& viewer) const;
    /// Width over height of its pictures, as far as that is known. Mutex held.
    double aspect() const;
    void tellRole(const Seat& seat, std::optional<uint32_t> inputId) const;
    void changeQuality(Seat& seat, const SettingsMessage& message);
    void checkVisible(const char* message) const;
    ViewRay rayThrough(double x, double y) const;
    void show();
    void stop();
    void rest();
    void effectCosts(EffectMeter::News&& news);
    void dropEffectCosts(const std::string& why);
    void accuracy(AccuracyMeter::News&& news);
    void giveUpAccuracy();
    void dropMeasurements();

    void openScene(const std::string& name);
    void sceneProgress(uint64_t order, const std::string& what, double share);
    void sceneReady(uint64_t order, std::shared_ptr<ResidentScene> scene);
    void sceneFailed(uint64_t order, const std::string& why);

    SessionHost& host_;
    Metrics& metrics_;
    const uint32_t number_;
    const std::string id_;
    const SettingCaps caps_;
    const Clock::time_point opened_ = Clock::now();

    mutable std::mutex mutex_;  // of what stands before meter_; held while calling viewers and loop_, never while calling host_
    std::vector<Seat> seats_;   // in the order they came; the first drives
    bool ended_ = false;
    ViewRequest request_;
    std::shared_ptr<ResidentScene> scene_;
    std::string sceneName_;     // of scene_
    uint64_t sceneOrder_ = 0;   // the newest one
    std::string orderedName_;   // its scene
    std::string sceneFailure_;  // of the newest one
    std::shared_ptr<void> sceneTicket_;
    Clock::time_point progressAt_{};
    bool playing_ = false;
    std::string lastFailure_;
    std::optional<FinishedFrame> newest_;       // until everybody has been given it
    std::shared_ptr<SharedPictures> shared_;    // of the newest, where several look
    std::optional<FinishedFrame> picture_;      // until who asked for it is free to take it
    std::optional<PictureOrder> pictureAsked_;  // until it is there
    double secondsPerFrame_ = 0.0;              // device time of first passes, smoothed
    Clock::time_point frameAt_{};               // the last one

    uint64_t costsOrder_ = 0;  // the newest asked for
    bool costsAwaited_ = false;
    Clock::time_point costsAt_{};
    uint64_t accuracyOrder_ = 0;  // the newest asked for
    bool accuracyAwaited_ = false;
    Clock::time_point accuracyAt_{};

    EffectMeter meter_;
    AccuracyMeter accuracyMeter_;
    FrameLoop loop_;  // ends first
};

}  // namespace heliograph

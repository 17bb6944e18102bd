#pragma once
// The render loop of one viewer: newest wish in, films to be shown out. It runs on a thread of its own and shares the
// device with other loops by taking turns (turns.h). While the viewer moves, every frame is one pass of one sample; at rest
// passes accumulate up to the `samples` setting. The rules of who gives way to whom are in view_request.h.

#include "server/request/effect_rules.h"
#include "server/device/device.h"
#include "server/film/film_pool.h"
#include "server/net/protocol.h"
#include "server/film/cell_reach.h"
#include "server/schedule/frame_history.h"
#include "server/stream/path_run.h"
#include "server/render/pass_renderer.h"
#include "server/request/view_request.h"

#include <condition_variable>
#include <optional>
#include <thread>

namespace heliograph {

/// A scene that a device holds, ready to be rendered.
struct ResidentScene {
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<Device> device;
    std::vector<EffectReason> reasons;  // explainEffects of the scene
    EffectSet effects;                  // that it calls for
};

/// A picture that a viewer asked for.
struct PictureOrder {
    uint32_t number = 0;  // counts the viewer's orders
    PictureFormat format = PictureFormat::png;
};

/// A film worth looking at. The film may grow while it is developed, never change its request.
struct FinishedFrame {
    std::optional<PictureOrder> picture;  // nothing: a frame of the view
    std::shared_ptr<const Film> film;     // its locked functions alone: once let go of, the loop uses it again
    uvec2 size{0, 0};                     // of the film
    ViewRequest view;
    uint32_t generation = 0;
    uint32_t samples = 0;        // per pixel
    bool final = false;          // the sample target is reached
    bool path = false;           // part of a run along the camera path
    float sceneExposure = 0.0f;  // EV
    double inputSeconds = 0.0;   // from the input to the start of its first pass
    PassFigures figures;
};

/// Whether the other end takes a frame now.
enum class Readiness {
    ready,
    busy,      // soon: the frame before is being encoded
    noCredit,  // when the viewer has acknowledged one
    stalled,   // the viewer has not acknowledged anything for long
};

/// Where a viewer wants to know the depth.
struct FocusRequest {
    ViewRay ray;
    uint32_t inputId = 0;
};

/// Where frames go. Called from the loop's thread without any lock held; must not call the loop's destructor.
class FrameReceiver {
public:
    virtual ~FrameReceiver() = default;
    virtual Readiness readiness() = 0;
    /// Pictures are not subject to credit, only to `busy`.
    virtual void take(FinishedFrame&& frame) = 0;
    /// A run along the path is over, or was asked to end before it began (no frames then).
    virtual void pathEnded(const FrameSummary& result) = 0;
    /// The depth that was asked for.
    virtual void focused(const FocusRequest& request, const DepthAnswer& answer) = 0;
    /// The device failed; the loop rests until the next wish or scene.
    virtual void failed(const std::string& what) = 0;
};

class FrameLoop {
public:
    FrameLoop(Turns& turns, FrameReceiver& receiver, FilmPool films = FilmPool());
    /// Ends the pass in flight and waits for the thread.
    ~FrameLoop();

    /// The newest wish replaces the one before; may cancel the pass in flight.
    void show(const ViewRequest& request);
    /// Renders this scene from now on; null stops rendering. `request` comes into force with it, so that nobody sees the
    /// new scene through the old one's camera.
    void setScene(std::shared_ptr<ResidentScene> scene, const std::optional<ViewRequest>& request = std::nullopt);
    /// Starts a run along the scene's first path, or ends the one in progress. Without a path it ends at once.
    void playPath(bool playing);
    /// Makes a picture of the newest wish at full resolution, with as many samples as its film has by now (at least 1).
    void takePicture(const PictureOrder& order);
    /// Asks the device for the depth along a ray, on the loop's thread; a request that was not answered yet is dropped.
    void focus(const FocusRequest& request);
    /// The receiver's readiness has changed for the better.
    void wake();
    /// Asks the loop to end, without waiting.
    void stop();
    /// Seconds that this loop and that all loops have used the device.
    Turns::Used used() const { return passes_.used(); }

private:
    using Clock = std::chrono::steady_clock;
    struct Run {
        PathRun path;
        Clock::time_point begin;
    };
    struct Job {
        PictureOrder order;
        ViewRequest view;
        FrameRequest request;
        std::shared_ptr<Film> film;
        uint32_t samples = 1;
        PassFigures figures;
    };
    struct PassState {
        bool running = false;
        bool cancellable = false;  // by a newer wish; ending the loop and a new scene always cancel
        ViewRequest view;
        uint32_t firstSample = 0;
        std::stop_source stop;
    };

    void run(std::stop_token stop);
    uint64_t takeNews();
    bool step();
    void followPath();
    void endRun();
    bool adopt();
    bool showsWish() const;
    void startFilm();
    bool deliver();
    void renderFilm();
    void useLatestWish();
    void beginPicture(const PictureOrder& order);
    void startPicture(const PictureOrder& order);
    bool finishPicture();
    std::stop_token beginPass(const ViewRequest& view, uint32_t firstSample, bool cancellable);
    void endPass(bool completed);
    bool renderPass(const FrameRequest& request, Film& film, uint32_t firstSample, std::stop_token cancelled,
                    std::optional<Turns::Turn> turn, PassFigures& figures);

    Turns& turns_;
    FrameReceiver& receiver_;
    PassRenderer passes_;

    // Between threads, under mutex_.
    mutable std::mutex mutex_;
    std::condition_variable_any changed_;
    uint64_t news_ = 0;  // grows with every call from outside
    std::optional<ViewRequest> newest_;
    std::shared_ptr<ResidentScene> newScene_;
    bool sceneChanged_ = false;
    std::optional<bool> playing_;
    std::optional<PictureOrder> pictureAsked_;
    std::optional<FocusRequest> focusAsked_;
    bool retry_ = false;  // something came that may mend what failed
    bool stopped_ = false;
    PassState pass_;
    bool cancelledBefore_ = false;  // the first pass before this one was given up

    // The loop's own.
    std::shared_ptr<ResidentScene> resident_;
    std::optional<ViewRequest> wish_;  // newest_ as taken, with the path's camera while a run plays
    std::optional<ViewRequest> view_;  // what the film shows
    FilmPool films_;
    std::shared_ptr<Film> film_;
    FrameRequest request_;  // of the film
    uint32_t generation_ = 0;
    uint32_t samples_ = 0;
    Delivery delivered_;
    ViewRequest deliveredView_;
    Clock::time_point deliveredAt_{};
    double inputSeconds_ = 0.0;
    PassFigures figures_;
    std::shared_ptr<FrameHistory> history_ = std::make_shared<FrameHistory>();
    ReachOfView reach_;
    std::optional<Run> run_;
    std::optional<PictureOrder> pictureWanted_;
    std::optional<Job> picture_;
    std::optional<FocusRequest> focus_;
    bool pictureTurn_ = false;  // passes of picture and film alternate
    bool broken_ = false;

    std::jthread thread_;  // last: it uses all of the above
};

}  // namespace heliograph

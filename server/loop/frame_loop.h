#pragma once
// The render loop of one view: newest request in, films to be shown out. It runs on a thread of its own, which is there while
// there is something to draw, and shares the device with other loops by taking turns (turns.h). While the viewer moves, every frame is one pass of one sample; at rest passes
// accumulate up to the `samples` setting. What it does next is decided in loop_rules.h.

#include "server/base/resting_thread.h"
#include "server/base/stage_clock.h"
#include "server/loop/path_run.h"
#include "server/loop/picture_job.h"
#include "server/loop/view_pace.h"

#include <optional>

namespace heliograph {

class FrameLoop {
public:
    FrameLoop(Turns& turns, FrameReceiver& receiver, FilmPool films = FilmPool());
    /// Ends the pass in flight and waits for the thread.
    ~FrameLoop();

    /// The newest request replaces the one before; may cancel the pass in flight.
    void show(const ViewRequest& request);
    /// Renders this scene from now on; null stops rendering. `request` comes into force with it, so that nobody sees the
    /// new scene through the old one's camera.
    void setScene(std::shared_ptr<ResidentScene> scene, const std::optional<ViewRequest>& request = std::nullopt);
    /// Starts a run along the scene's first path, or ends the one in progress. Without a path it ends at once.
    void playPath(bool playing);
    /// Makes a picture of the newest request at full resolution, with as many samples as its film has by now (at least 1).
    void takePicture(const PictureOrder& order);
    /// Delivers the frame that was delivered last once more, for somebody who has not seen it.
    void offerAgain();
    /// Asks the device for the depth along a ray, on the loop's thread; a request that was not answered yet is dropped.
    void focus(const FocusRequest& request);
    /// The same for what is there, beside `focus`; neither replaces the other.
    void pick(const PickRequest& request);
    /// The receiver's readiness has changed for the better.
    void wake();
    /// To be called now and then. False where what was asked waits because the system has no thread for it.
    bool retry() { return thread_.retry(); }
    /// Whether its thread is there.
    bool awake() const { return thread_.awake(); }
    /// Asks the loop to end, without waiting.
    void stop();
    /// Seconds that this loop and that all loops have used the device.
    Turns::Used used() const { return passes_.used(); }
    /// By how much pictures are smaller while the viewer moves.
    ScaleFigures scale() const;
    /// What they do without for a time budget.
    AutopilotFigures autopilot() const;
    /// What it is at that may last: the device has the thread. `viewer`: for whom.
    std::optional<RunningStage> stage(uint32_t viewer) const;

private:
    using Clock = std::chrono::steady_clock;
    struct Run {
        PathRun path;
        Clock::time_point begin;
    };
    struct PassState {
        bool running = false;
        bool cancellable = false;  // by a newer request; ending the loop and a new scene always cancel
        ViewRequest view;
        uint32_t firstSample = 0;
        std::stop_source stop;
    };

    template <typename Change>
    void tell(Change change);
    bool turn();
    void giveUp(const char* why);
    void takeNews();
    bool step();
    LoopState state();
    void askDevice();
    void followPath();
    void endRun();
    void startPicture(const PictureOrder& order);
    void renderFilm();
    void useLatestRequest();
    void takeRequest();
    void denoiseFilm();
    void deliverFilm();
    void renderPicture();
    void deliverPicture();
    std::stop_token beginPass(const ViewRequest& view, uint32_t firstSample, bool cancellable);
    void endPass(bool completed);

    Turns& turns_;
    FrameReceiver& receiver_;
    PassRenderer passes_;

    StageClock stages_;  // beside passes

    // Between threads, under mutex_.
    mutable std::mutex mutex_;
    std::optional<ViewRequest> newest_;
    ViewPace pace_;
    std::shared_ptr<ResidentScene> newScene_;
    bool sceneChanged_ = false;
    std::optional<bool> playing_;
    std::optional<PictureOrder> pictureAsked_;
    std::optional<FocusRequest> focusAsked_;
    std::optional<PickRequest> pickAsked_;
    bool again_ = false;  // the frame that was delivered last is asked for
    bool retry_ = false;  // something came that may mend what failed
    bool stopped_ = false;
    PassState pass_;
    bool cancelledBefore_ = false;  // the first pass before this one was given up

    // The loop's own.
    std::shared_ptr<ResidentScene> resident_;
    std::optional<ViewRequest>
        request_;  // newest_ as taken: at the scale of the moment, or with the camera of the run that plays
    ViewFilm film_;
    std::optional<Run> run_;
    std::optional<PictureOrder> pictureWanted_;
    std::optional<PictureJob> picture_;
    bool pictureTurn_ = false;  // passes of picture and film alternate
    std::optional<FocusRequest> focus_;
    std::optional<PickRequest> pick_;
    bool broken_ = false;
    std::string denoiserFault_;  // told already

    RestingThread thread_;  // last: it uses all of the above
};

}  // namespace heliograph

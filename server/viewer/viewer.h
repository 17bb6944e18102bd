#pragma once
// One who looks at a view: its socket, its credit, and the codec and quality of what it is sent. Frames come finished from a
// view, which knows nothing of who looks; several viewers may be given the same one, each makes its own bytes of it. What is
// said and asked for is the session's.

#include "server/net/viewer_socket.h"
#include "server/pace/codec_choice.h"
#include "server/pace/line_meter.h"
#include "server/pace/quality_ladder.h"
#include "server/viewer/encode_thread.h"
#include "server/viewer/metrics.h"
#include "server/viewer/stats_window.h"

namespace heliograph {

/// What a viewer tells of itself; from any thread, without any lock of the viewer held.
class ViewerListener {
public:
    virtual ~ViewerListener() = default;
    /// It may take another frame now: the one event that drives delivery, whether credit came, a frame was encoded, or both.
    virtual void drained() = 0;
    /// A frame or picture could not be made into bytes.
    virtual void encodingFailed(const std::string& what) = 0;
};

/// Safe from all threads.
class Viewer {
public:
    using Clock = std::chrono::steady_clock;

    Viewer(uint32_t number, std::shared_ptr<ViewerSocket> socket, Metrics& metrics, ViewerListener& listener);
    ~Viewer() { finish(); }

    uint32_t number() const { return number_; }
    void say(std::string text) { socket_->sendText(std::move(text)); }
    void close(CloseCode code, const std::string& reason) { socket_->close(code, reason); }

    /// JPEG quality of the frames from now on, 1..100.
    void setQuality(uint32_t quality);
    /// What is at the other end. Where nobody sees pictures none are sent.
    void setClient(const ClientMessage& client);
    bool visible() const;
    Readiness readiness() const;
    /// Encodes and sends the frame; only when `readiness` is ready, for a picture when it is not busy.
    /// `shared`: of all who are given this frame; null where nobody else is.
    void take(FinishedFrame frame, std::shared_ptr<SharedPictures> shared = nullptr);
    /// Goes on with the parts of the last picture, which make it exact; false where there are none, or no room. To be called
    /// when there is nothing else to take.
    bool refine();
    /// No frame is being encoded or waits to be acknowledged, or nothing was for long.
    bool nothingOnItsWay() const;
    /// The viewer has shown a frame, or cannot: then a video begins anew. Throws InputError for one that was never sent.
    void acknowledge(const AckMessage& message);
    /// The viewer has measured a round trip.
    void pinged(double roundTripSeconds);
    /// Steps (moving_scale.h) by which pictures of a moving view should be smaller, for what lies between server and eye.
    uint32_t coarser() const;

    /// The order of a picture, which is to come back with its frame. Throws InputError while another one is being made.
    PictureOrder orderPicture(PictureFormat format);
    /// Gives up the picture that is being made; false if there is none.
    bool dropPicture();

    /// A frame or picture left, as ViewerPeer::written.
    void written(FrameKind kind, double waitSeconds, double writeSeconds);
    /// Closes the connection of one who has acknowledged nothing for STALL_CLOSE; true if so.
    bool closeIfStalled(Clock::time_point now);
    /// As StatsWindow::take.
    ViewerStats takeStats(double seconds, Turns::Used used);
    bool statsChanged(Turns::Used used) const;
    /// Ends after the frame in work and waits for that. After it the listener is not called any more.
    void finish() { encoder_.finish(); }
    /// As EncodeThread::retry.
    bool retry() { return encoder_.retry(); }
    bool awake() const { return encoder_.awake(); }
    /// What its thread is at.
    std::optional<RunningStage> stage() const { return encoder_.stage(number_); }
    /// Processor time in which a picture is developed and encoded; 0 while none was.
    double pictureSeconds() const;

private:
    void encoded(uint32_t frameId, std::optional<EncodedFrame> frame, const std::string& failure);
    void send(EncodedFrame&& frame);
    uint32_t qualityOf(const FinishedFrame& frame);
    FrameCodec codecOf(const FinishedFrame& frame);
    bool video() const { return isVideo(sentAs_); }
    void queued(const QueueDelay& delay, double now);

    const uint32_t number_;
    const std::shared_ptr<ViewerSocket> socket_;
    Metrics& metrics_;
    ViewerListener& listener_;

    mutable std::mutex mutex_;  // of all below; held while calling socket_
    uint32_t quality_ = 80;
    ClientMessage client_;
    uint32_t lastFrameId_ = 0;
    std::shared_ptr<const StillPicture> still_;  // the last picture, until all its parts were sent
    uint32_t stillRows_ = 0;                     // of it, that were
    bool unwritten_ = false;                     // a frame or part waits in the socket, where the next one would replace it,
                                                 // or one of a video is on its way there
    LineMeter line_;                             // and the frames on their way
    QualityLadder ladder_;
    CodecChoice codec_;
    bool choosesCodec_ = false;             // nobody has asked for one, and there is a choice
    FrameCodec sentAs_ = FrameCodec::jpeg;  // the last frame; the next one of a video builds on it
    bool keyWanted_ = false;                // the next one begins it anew
    uint32_t lastKey_ = 0;                  // the last frame that did
    LineFigures figures_;
    double frameSeconds_ = 0.05;  // of a pass while the view moves, smoothed
    uint32_t lastPicture_ = 0;
    bool pictureAwaited_ = false;  // lastPicture_ was asked for and is not yet sent
    StatsWindow stats_;
    double pictureSeconds_ = 0.0;  // smoothed

    EncodeThread encoder_;  // ends first
};

}  // namespace heliograph

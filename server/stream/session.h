#pragma once
// Joins one viewer and the view it looks at: newest request in, newest frame out. It checks what the viewer asks, keeps the
// camera and the settings, and says what becomes of them. A fault of a viewer is answered to that viewer alone.

#include "server/stream/admission.h"
#include "server/loop/frame_loop.h"
#include "server/stream/messages.h"
#include "server/stream/viewer.h"

namespace heliograph {

/// How the opening of a scene tells a session about itself; from any thread.
struct SceneListener {
    std::function<void(const std::string& what, double share)> progress;
    std::function<void(std::shared_ptr<ResidentScene>)> ready;
    std::function<void(const std::string& why, std::exception_ptr error)> failed;
};

/// What all sessions share. Safe from all threads; never called with a session's lock held.
class SessionHost {
public:
    virtual ~SessionHost() = default;
    /// The scenes on offer; the first is where a viewer starts.
    virtual std::vector<SceneRecipe> scenes() const = 0;
    /// Words of the setting `device` that a viewer may choose.
    virtual std::vector<std::string> devices() const = 0;
    /// Opens one of them in the background. After the returned ticket is gone the listener is not called any more (a call
    /// in progress may still end). Throws InputError when no further scene fits.
    virtual std::shared_ptr<void> openScene(const std::string& name, SceneListener listener) = 0;
    /// Grants a viewer pixels of a picture instead of what it had before. Returns how many: fewer than `wanted` where the
    /// memory for pictures does not suffice, at least 1.
    virtual uint64_t grantPixels(uint32_t viewer, uint64_t wanted) = 0;
    virtual size_t viewerCount() const = 0;
    virtual Turns& turns() = 0;
    virtual Metrics& metrics() = 0;
};

class Session : public ViewerPeer, public std::enable_shared_from_this<Session>, private FrameReceiver, private ViewerListener {
public:
    using Clock = std::chrono::steady_clock;

    struct Options {
        Settings defaults;
        std::string token;        // empty: none is asked for
        bool authorized = false;  // the token came with the connection
        SettingCaps caps = {};
    };

    Session(uint32_t viewer, SessionHost& host, std::shared_ptr<ViewerSocket> socket, Options options);
    /// Waits for the threads of the viewer.
    ~Session();

    /// Greets the viewer and opens the first scene, unless a token has to come first.
    void begin();
    void receive(std::string_view text) override;
    void written(FrameKind kind, double waitSeconds, double writeSeconds) override {
        viewer_.written(kind, waitSeconds, writeSeconds);
    }
    /// To be called some times a second: statistics, limits of time.
    void tick(Clock::time_point now);
    /// What it has used of the device lately.
    ViewerLoad load(Clock::time_point now) const;
    /// Tells the viewer something in one line.
    void notice(const std::string& what);
    /// The server ends: the viewer is told, and what it sends is not taken any more but acknowledgements.
    void drain(std::chrono::milliseconds atMost);
    /// Nothing is on its way to the viewer any more that it waits for: its last input was answered by a frame, which it has
    /// acknowledged.
    bool settled();
    /// The viewer has gone: ends all work without waiting.
    void end();

    uint32_t viewer() const { return viewer_.number(); }

private:
    // FrameReceiver
    Readiness readiness() override { return viewer_.readiness(); }
    void take(FinishedFrame&& frame) override;
    void pathEnded(const FrameSummary& result) override;
    void focused(const FocusRequest& request, const DepthAnswer& answer) override;
    void failed(const std::string& what) override;
    // ViewerListener
    void drained() override { loop_.wake(); }
    void encodingFailed(const std::string& what) override { failed(what); }

    void handle(const CameraMessage& message);
    void handle(const SettingsMessage& message);
    void handle(const ResolutionMessage& message);
    void handle(const SceneMessage& message);
    void handle(const AckMessage& message);
    void handle(const PictureMessage& message);
    void handle(const PathMessage& message);
    void handle(const PingMessage& message);
    void handle(const TokenMessage& message);
    void handle(const EffectCostsMessage& message);
    void handle(const FocusMessage& message);

    bool draining();
    void welcome();
    void openScene(const std::string& name);
    void sceneProgress(uint64_t order, const std::string& what, double share);
    void sceneReady(uint64_t order, std::shared_ptr<ResidentScene> scene);
    void sceneFailed(uint64_t order, const std::string& why);
    void refuse(const InputError& error, const std::string& about, std::optional<uint32_t> inputId);
    void checkVisible(const char* message) const;
    void showLocked();
    void effectCosts(EffectMeter::News&& news);
    void dropEffectCosts(const std::string& why);

    SessionHost& host_;
    Metrics& metrics_;
    const Options options_;
    const Clock::time_point opened_ = Clock::now();
    uint32_t newestInput_ = 0;  // of the messages that were taken; the socket's thread alone

    mutable std::mutex
        mutex_;  // of what stands before viewer_; held while calling viewer_ and loop_, never while calling host_
    bool authorized_ = false;
    bool ended_ = false;
    bool draining_ = false;
    uint32_t shownInput_ = 0;  // of the newest frame that was given to the viewer
    ViewRequest request_;
    std::shared_ptr<ResidentScene> scene_;
    std::string sceneName_;    // of scene_
    uint64_t sceneOrder_ = 0;  // the newest one
    std::string orderedName_;  // its scene
    std::shared_ptr<void> sceneTicket_;
    Clock::time_point progressAt_{};
    bool playing_ = false;
    std::string lastFailure_;
    Clock::time_point statsAt_{};
    double secondsPerFrame_ = 0.0;  // device time of first passes, smoothed
    Clock::time_point frameAt_{};   // the last one

    uint64_t costsOrder_ = 0;  // the newest asked for
    bool costsAwaited_ = false;
    Clock::time_point costsAt_{};

    EffectMeter meter_;
    Viewer viewer_;
    FrameLoop loop_;  // ends first
};

}  // namespace heliograph

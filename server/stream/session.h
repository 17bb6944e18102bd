#pragma once
// One browser: its token, what it says, and which view it looks at. Messages are read and checked here; those that are about the
// view go to the view, those about the viewer are answered here. A fault of a viewer is answered to that viewer alone.

#include "server/viewer/messages.h"
#include "server/stream/views.h"

namespace heliograph {

class Session : public ViewerPeer, private ViewerListener {
public:
    using Clock = std::chrono::steady_clock;

    struct Options {
        Settings defaults;
        std::string token;        // empty: none is asked for
        bool authorized = false;  // the token came with the connection
        SettingCaps caps = {};
    };

    Session(uint32_t viewer, SessionHost& host, std::shared_ptr<ViewerSocket> socket, Options options);
    /// Waits for the thread of the viewer.
    ~Session();

    /// Greets the viewer and opens a view of its own with the first scene, unless a token has to come first.
    void begin();
    void receive(std::string_view text) override;
    void written(FrameKind kind, double waitSeconds, double writeSeconds) override {
        viewer_.written(kind, waitSeconds, writeSeconds);
    }
    /// To be called some times a second: statistics, limits of time.
    void tick(Clock::time_point now);
    /// What its view has used of the device lately; nothing where it watches another viewer's.
    std::optional<ViewerLoad> load(Clock::time_point now) const;
    /// What is being done for it.
    std::vector<RunningStage> stages() const;
    /// Tells the viewer something in one line.
    void notice(const std::string& what);
    /// The server ends: the viewer is told, and what it sends is not taken any more but acknowledgements.
    void drain(std::chrono::milliseconds atMost);
    /// Nothing is on its way to the viewer any more that it waits for: its last input was answered by a frame, which it has
    /// acknowledged.
    bool settled() const;
    /// Neither its view nor its viewer holds a thread.
    bool resting() const;
    void leaves() override { comesBack_ = false; }
    /// The viewer has gone: it leaves its view, without waiting. `broken`: not by our will; unless by its own, the view is kept
    /// for when it comes back.
    void end(bool broken = false);

    uint32_t viewer() const { return viewer_.number(); }

private:
    // ViewerListener
    void drained() override;
    void encodingFailed(const std::string& what) override;

    /// What is about the view.
    template <typename Message>
    void handle(const Message& message);
    void handle(const AckMessage& message) { viewer_.acknowledge(message); }
    void handle(const PingMessage& message);
    void handle(const ClientMessage& message) { viewer_.setClient(message); }
    void handle(const TokenMessage& message);
    void handle(const WatchMessage& message);

    std::shared_ptr<View> view() const;
    bool draining() const;
    void retry();
    void welcome();
    void leave(bool keep = false);
    bool enter(const std::shared_ptr<View>& view, std::shared_ptr<void> place, std::optional<uint32_t> inputId,
               const std::string& formerKey = {});
    void refuse(const InputError& error, const std::string& about, std::optional<uint32_t> inputId);

    SessionHost& host_;
    Metrics& metrics_;
    const Options options_;
    const std::string key_;  // SeatKeys::own
    const Clock::time_point opened_ = Clock::now();
    std::atomic<bool> comesBack_{true};  // it has not said goodbye
    uint32_t newestInput_ = 0;           // of the messages that were taken; the socket's thread alone

    mutable std::mutex
        mutex_;  // of what stands before viewer_; held while calling viewer_, never while calling a view or host_
    bool authorized_ = false;
    bool ended_ = false;
    bool draining_ = false;
    std::shared_ptr<View> view_;   // from the welcome to the end
    std::shared_ptr<void> place_;  // in it, of the host
    Clock::time_point statsAt_{};
    size_t watchersTold_ = 0;  // in the last stats
    std::string lastFailure_;
    bool waits_ = false;  // for a thread, and was told

    Viewer viewer_;
};

}  // namespace heliograph

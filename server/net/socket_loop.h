#pragma once
// The thread of all connections: accepts, reads, decides, writes, and ends what lasts too long. What one of them does may cost
// the others at most a slice: 64 KiB read, 1 MiB written.

#include "server/base/log.h"
#include "server/net/admission.h"
#include "server/net/channel.h"
#include "server/net/rate_limit.h"
#include "server/net/socket_server.h"
#include "server/net/token.h"

#include <atomic>
#include <set>
#include <unordered_map>

namespace heliograph {

/// Lets other threads name the connections that have something to write.
class Waker {
public:
    Waker();  // throws std::system_error
    ~Waker();
    Waker(const Waker&) = delete;
    void wake(uint64_t id);
    /// The ids since the last call.
    std::set<uint64_t> take();
    int descriptor() const { return descriptor_; }

private:
    const int descriptor_;
    std::mutex mutex_;
    std::set<uint64_t> ids_;
};

class SocketLoop : private Site {
public:
    SocketLoop(SocketOptions options, SocketHandler& handler);
    ~SocketLoop() override;

    /// Serves until `stop`; then the viewers are told and all ends.
    void run();
    void stop();
    void wake() { waker_->wake(0); }
    void reload(const SocketAccess& access);
    void drain(bool draining) override { draining_ = draining; }
    const std::vector<Listener>& listeners() const { return listeners_; }
    bool secure() const { return secure_; }

private:
    using Clock = Channel::Clock;
    using Phase = Channel::Phase;

    // The loop.
    void checkReach(const SocketAccess& access) const;
    void checkDescriptors();
    void watch(int descriptor, uint64_t tag, uint32_t events);
    void tryAccept(const Listener& listener);
    void acceptFrom(const Listener& listener);
    bool makeRoom(const PeerAddress& peer, bool& reserved);
    void pauseAccepting(int error);
    void listenAgain();
    void serve(uint64_t id, uint32_t events);
    bool advance(Channel& channel);
    bool settle(Channel& channel);
    uint32_t wantedEvents(const Channel& channel) const;
    void sweep();
    bool inTime(Channel& channel);
    void drop(uint64_t id);
    bool anybodyHasToHear() const;
    void goodbye();
    void takeReload();
    std::vector<Waiting> waiting(bool guests) const;

    // What is said.
    void readRequests(Channel& channel);
    void request(Channel& channel, const HttpRequest& request);
    std::optional<HttpAnswer> upgrade(Channel& channel, const HttpRequest& request, Scope scope);
    std::optional<HttpAnswer> checkToken(Channel& channel, const HttpRequest& request, Scope& scope);
    std::string noRoom();
    void refuse(Channel& channel, HttpAnswer answer, bool withBody = true);
    Scope scopeOf(std::string_view token) const;
    void wrongToken(Channel& channel);
    void readFrames(Channel& channel);
    bool take(Channel& channel, const FrameReader::Piece& piece);
    bool takeControl(Channel& channel, const FrameReader::Piece& piece);
    void takeGuest(Channel& channel, const FrameReader::Piece& piece);
    void open(Channel& channel);
    void note(const Channel& channel, LogLevel level, const std::string& what);

    // Site
    const ClientFiles& files() const override { return options_.files; }
    std::string metricsText() override { return handler_.metricsText(); }
    std::string readiness(bool& ready) override;
    bool needsToken() const override { return !access_.token.empty(); }
    bool hasAdmin() const override { return !access_.adminToken.empty(); }
    nlohmann::json viewers() override;
    bool disconnect(uint32_t viewer) override;
    std::vector<std::string> sceneNames() override { return handler_.sceneNames(); }
    bool openScene(const std::string& name) override { return handler_.loadScene(name); }

    const SocketOptions options_;
    SocketHandler& handler_;
    const std::string machine_;  // its name
    SocketAccess access_;        // as it is now
    TlsContext tls_;
    const bool secure_;
    std::vector<Listener> listeners_;
    const int epoll_;
    std::shared_ptr<Waker> waker_ = std::make_shared<Waker>();

    Clock::time_point now_{};
    std::unordered_map<uint64_t, std::unique_ptr<Channel>> channels_;
    std::map<std::string, size_t> perAddress_;
    uint64_t lastId_ = 0;
    size_t viewerCount_ = 0;
    size_t descriptorRoom_ = 0;  // connections that the descriptors are enough for
    std::set<uint64_t> again_;   // have something to read that the system does not tell of
    TokenGuard guard_;
    std::optional<Clock::time_point> acceptAgain_;
    bool pauseSaid_ = false;
    RateLimit noteRate_{50.0, 200.0};
    uint64_t notesLeftOut_ = 0;

    std::atomic<bool> stopping_{false}, draining_{false};
    std::mutex reloadMutex_;
    struct Reload {
        SocketAccess access;
        TlsContext tls;
    };
    std::optional<Reload> reload_;
};

}  // namespace heliograph

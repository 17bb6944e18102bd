#include "server/net/socket_loop.h"

#include "server/base/clock.h"
#include "server/base/error.h"
#include "server/base/log.h"

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <system_error>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto SWEEP = 250ms;          // between looks at the time limits of all
constexpr auto GOODBYE = 150ms;        // for close frames when the server ends
constexpr auto LINGER = 1000ms;        // for the other side to read what it was told last
constexpr auto ACCEPT_PAUSE = 1000ms;  // when descriptors or memory are out
constexpr size_t OTHER_DESCRIPTORS = 64;
constexpr int ACCEPTED_AT_ONCE = 64;
// Tags of what is waited for: channels have numbers from 1 on.
constexpr uint64_t TAG_WAKER = 0, TAG_LISTENER = uint64_t{1} << 63;

std::string machineName() {
    char name[256] = "";
    return gethostname(name, sizeof name - 1) == 0 ? name : "";
}

std::vector<Listener> listenOnAll(const SocketOptions& options) {
    std::vector<Listener> all = listenOn(options.listen);
    for (const ListenAddress& address : options.moreListens) {
        for (Listener& listener : listenOn(address)) all.push_back(std::move(listener));
    }
    return all;
}

TlsContext tlsOf(const SocketAccess& access) {
    if (access.certificateFile.empty()) return nullptr;
    std::vector<std::string> warnings;
    TlsContext tls = loadTls(access.certificateFile, access.keyFile, warnings);
    for (const std::string& warning : warnings) log().warn("{}", warning);
    return tls;
}

}  // namespace

Waker::Waker() : descriptor_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

Waker::~Waker() { ::close(descriptor_); }

void Waker::wake(uint64_t id) {
    {
        std::lock_guard lock(mutex_);
        if (!ids_.insert(id).second) return;
    }
    const uint64_t one = 1;
    // Fails only when the counter is full, and then the loop is awake.
    [[maybe_unused]] const ssize_t written = ::write(descriptor_, &one, sizeof one);
}

std::set<uint64_t> Waker::take() {
    uint64_t count = 0;
    [[maybe_unused]] const ssize_t taken = ::read(descriptor_, &count, sizeof count);
    std::lock_guard lock(mutex_);
    return std::exchange(ids_, {});
}

SocketLoop::SocketLoop(SocketOptions options, SocketHandler& handler)
    : options_(std::move(options)),
      handler_(handler),
      machine_(machineName()),
      access_(options_),
      tls_(tlsOf(access_)),
      secure_(tls_ != nullptr),
      listeners_(listenOnAll(options_)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)) {
    if (epoll_ < 0) throw std::system_error(errno, std::generic_category(), "epoll");
    checkReach(access_);
    checkDescriptors();
    watch(waker_->descriptor(), TAG_WAKER, EPOLLIN);
    listenAgain();
}

SocketLoop::~SocketLoop() {
    while (!channels_.empty()) drop(channels_.begin()->first);
    ::close(epoll_);
}

/// Throws InputError where other machines could come in without a token.
void SocketLoop::checkReach(const SocketAccess& access) const {
    if (options_.insecure || !access.token.empty()) return;
    for (const Listener& listener : listeners_) {
        if (listener.local()) continue;
        throw InputError("--listen", listener.address().text() + " can be reached from other machines",
                         "that with --token-file FILE, or with --insecure to let everybody in; or 127.0.0.1");
    }
}

void SocketLoop::checkDescriptors() {
    const size_t wanted = access_.maxViewers + options_.spareConnections + RESERVED_CONNECTIONS;
    const size_t limit = raiseDescriptorLimit(wanted + OTHER_DESCRIPTORS);
    descriptorRoom_ = std::min(wanted, limit > 2 * OTHER_DESCRIPTORS ? limit - OTHER_DESCRIPTORS : limit / 2);
    if (descriptorRoom_ < wanted) {
        log().warn("{} descriptors are allowed (ulimit -n), {} wanted: room for {} connections, {} of them viewers", limit,
                   wanted + OTHER_DESCRIPTORS, descriptorRoom_, std::min(access_.maxViewers, descriptorRoom_ * 3 / 4));
    }
}

void SocketLoop::watch(int descriptor, uint64_t tag, uint32_t events) {
    epoll_event event{};
    event.events = events;
    event.data.u64 = tag;
    if (epoll_ctl(epoll_, EPOLL_CTL_MOD, descriptor, &event) == 0 || errno != ENOENT) return;
    if (epoll_ctl(epoll_, EPOLL_CTL_ADD, descriptor, &event) != 0)
        throw std::system_error(errno, std::generic_category(), "epoll");
}

void SocketLoop::stop() {
    stopping_ = true;
    waker_->wake(0);
}

void SocketLoop::reload(const SocketAccess& access) {
    if (access.certificateFile.empty() == secure_)
        throw InputError("--tls-cert", secure_ ? "missing" : "given", "TLS begins and ends with a restart alone");
    checkReach(access);
    Reload reload{access, tlsOf(access)};
    {
        std::lock_guard lock(reloadMutex_);
        reload_ = std::move(reload);
    }
    waker_->wake(0);
}

void SocketLoop::takeReload() {
    std::lock_guard lock(reloadMutex_);
    if (!reload_) return;
    access_ = std::move(reload_->access);
    tls_ = std::move(reload_->tls);
    reload_.reset();
    checkDescriptors();
}

void SocketLoop::run() {
    // OpenSSL writes to sockets that may be closed. Of this thread alone: the rest of the process decides for itself.
    sigset_t pipe;
    sigemptyset(&pipe);
    sigaddset(&pipe, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
    epoll_event events[128];
    std::optional<Clock::time_point> deadline;
    Clock::time_point swept{};
    while (!deadline || (anybodyHasToHear() && Clock::now() < *deadline)) {
        const auto wait = !again_.empty() ? 0ms : deadline ? 10ms : SWEEP;
        const int count = epoll_wait(epoll_, events, std::size(events), static_cast<int>(wait.count()));
        now_ = Clock::now();
        takeReload();
        if (stopping_ && !deadline) {
            deadline = now_ + GOODBYE;
            goodbye();
        }
        for (uint64_t id : std::exchange(again_, {})) serve(id, EPOLLIN);
        for (int i = 0; i < count; i++) {
            const uint64_t tag = events[i].data.u64;
            if (tag == TAG_WAKER) {
                handler_.turned();
                for (uint64_t id : waker_->take()) serve(id, 0);
            } else if (tag & TAG_LISTENER) {
                tryAccept(listeners_[tag & ~TAG_LISTENER]);
            } else {
                serve(tag, events[i].events);
            }
        }
        if (now_ - swept < SWEEP && !deadline) continue;
        swept = now_;
        sweep();
    }
    while (!channels_.empty()) drop(channels_.begin()->first);
}

/// A close frame is not out yet.
bool SocketLoop::anybodyHasToHear() const {
    return std::ranges::any_of(
        channels_, [](const auto& c) { return c.second->isWebSocket() || (c.second->closeCode && c.second->hasOutput()); });
}

/// No more connections; the viewers are told.
void SocketLoop::goodbye() {
    for (const Listener& listener : listeners_) watch(listener.descriptor(), TAG_LISTENER, 0);
    std::vector<uint64_t> ids;
    for (const auto& [id, channel] : channels_) ids.push_back(id);
    for (uint64_t id : ids) {
        Channel& channel = *channels_.at(id);
        if (channel.phase == Phase::viewer) channel.connection->close(CloseCode::goingAway, "the server ends");
        if (channel.phase == Phase::guest)
            channel.farewell(static_cast<uint16_t>(CloseCode::goingAway), "the server ends", now_);
        serve(id, 0);
    }
}

void SocketLoop::tryAccept(const Listener& listener) {
    try {
        acceptFrom(listener);
    } catch (const std::exception& e) {
        log().error("a connection could not be taken: {}", e.what());
    }
}

void SocketLoop::acceptFrom(const Listener& listener) {
    if (acceptAgain_ || stopping_) return;
    for (int i = 0; i < ACCEPTED_AT_ONCE; i++) {
        Listener::Accepted accepted = listener.accept();
        if (accepted.descriptor < 0) {
            const int e = accepted.error;
            if (e == EMFILE || e == ENFILE || e == ENOBUFS || e == ENOMEM) pauseAccepting(e);
            return;
        }
        pauseSaid_ = false;
        bool reserved = false;
        if (!makeRoom(accepted.peer, reserved)) {
            ::close(accepted.descriptor);
            handler_.refused(503, "too many connections");
            continue;
        }
        const std::string address = accepted.peer.key;
        auto channel = std::make_unique<Channel>(++lastId_, accepted.descriptor, std::move(accepted.peer), tls_, now_);
        channel->local = listener.local();
        channel->reserved = reserved;
        channel->events = EPOLLIN;
        watch(accepted.descriptor, channel->id, EPOLLIN);
        channels_.emplace(channel->id, std::move(channel));
        perAddress_[address]++;
    }
}

/// Connections that no viewer looks through: those on HTTP, or the guests.
std::vector<Waiting> SocketLoop::waiting(bool guests) const {
    std::vector<Waiting> all;
    for (const auto& [id, channel] : channels_) {
        if (channel->isWebSocket() != guests || channel->phase == Phase::viewer) continue;
        const double since = std::chrono::duration<double>(channel->since.time_since_epoch()).count();
        const bool answering = channel->phase == Phase::answer || channel->phase == Phase::delayed;
        all.push_back({id, channel->peer.key, answering, since});
    }
    return all;
}

/// False where there is none, even by taking it from an idle one.
bool SocketLoop::makeRoom(const PeerAddress& peer, bool& reserved) {
    const size_t most = std::min(access_.maxViewers + options_.spareConnections, descriptorRoom_ - descriptorRoom_ / 16);
    const size_t mostPerAddress = std::min(access_.maxViewers + options_.spareConnectionsPerAddress, most);
    auto of = perAddress_.find(peer.key);
    const bool manyOfAddress = of != perAddress_.end() && of->second >= mostPerAddress;
    if (!manyOfAddress && channels_.size() < most) return true;
    if (auto victim = whoGivesWay(waiting(false), manyOfAddress ? peer.key : "")) {
        channels_.at(*victim)->reason = "gave way to a newer connection";
        drop(*victim);
        return true;
    }
    reserved = true;
    return channels_.size() < most + RESERVED_CONNECTIONS;
}

/// Without descriptors the listening sockets stay readable: they are not looked at for a while, so that nothing spins.
void SocketLoop::pauseAccepting(int error) {
    acceptAgain_ = now_ + ACCEPT_PAUSE;
    for (size_t i = 0; i < listeners_.size(); i++) watch(listeners_[i].descriptor(), TAG_LISTENER | i, 0);
    if (std::exchange(pauseSaid_, true)) return;
    log().error("no connection can be accepted for now: {}; {} are open (ulimit -n)", std::generic_category().message(error),
                channels_.size());
    if (auto victim = whoGivesWay(waiting(false), "")) drop(*victim);
}

void SocketLoop::listenAgain() {
    acceptAgain_.reset();
    for (size_t i = 0; i < listeners_.size(); i++) watch(listeners_[i].descriptor(), TAG_LISTENER | i, EPOLLIN);
}

void SocketLoop::serve(uint64_t id, uint32_t events) {
    auto found = channels_.find(id);
    if (found == channels_.end()) return;
    Channel& channel = *found->second;
    try {
        if (events & EPOLLERR || ((events & EPOLLHUP) && !(events & EPOLLIN))) return drop(id);
        if ((events & EPOLLIN) && (wantedEvents(channel) & EPOLLIN) && !channel.receive(now_)) channel.ended = true;
        if (channel.phase == Phase::leaving && (events & EPOLLRDHUP)) channel.ended = true;
        if (!advance(channel)) return drop(id);
    } catch (const std::exception& e) {
        channel.reason = std::string("gave up: ") + e.what();
        log().error("connection of {} closed: {}", channel.peer.text, e.what());
        drop(id);
    }
}

/// Takes what has arrived and writes what waits. False when it is over.
bool SocketLoop::advance(Channel& channel) {
    for (int turn = 0; turn < 64; turn++) {
        if (channel.phase == Phase::request) readRequests(channel);
        else if (channel.isWebSocket()) readFrames(channel);
        else if (channel.phase == Phase::leaving) channel.arrived.clear();
        if (!channel.flush(now_)) return false;
        if (channel.phase != Phase::answer || channel.hasOutput()) return settle(channel);
        if (!channel.keepAlive || channel.ended) {
            channel.discards = true;
            channel.enter(Phase::leaving, now_);
            return settle(channel);
        }
        channel.enter(Phase::request, now_);
        if (channel.arrived.empty()) return settle(channel);
    }
    again_.insert(channel.id);
    return settle(channel);
}

/// Ends what has ended and asks the system for what can happen next.
bool SocketLoop::settle(Channel& channel) {
    if (channel.phase == Phase::leaving && !channel.hasOutput() && !std::exchange(channel.writingEnded, true)) {
        channel.transport.endWriting();
        channel.enter(Phase::leaving, now_);
    }
    if (channel.ended) {
        const bool answering = channel.phase == Phase::answer || channel.phase == Phase::delayed;
        if (!answering && !(channel.phase == Phase::leaving && channel.hasOutput())) return false;
    }
    const uint32_t wanted = wantedEvents(channel);
    if (wanted != channel.events) watch(channel.transport.descriptor(), channel.id, channel.events = wanted);
    if ((wanted & EPOLLIN) && channel.transport.hasUnread()) again_.insert(channel.id);
    return true;
}

uint32_t SocketLoop::wantedEvents(const Channel& channel) const {
    uint32_t wanted = channel.blocked() || channel.transport.handshakeWrites() ? uint32_t{EPOLLOUT} : 0u;
    if (channel.ended) return wanted;
    switch (channel.phase) {
        case Phase::request:
        case Phase::guest:
        case Phase::viewer: return wanted | EPOLLIN;
        case Phase::leaving: return wanted | EPOLLRDHUP | (channel.discards ? uint32_t{EPOLLIN} : 0u);
        case Phase::answer:
        case Phase::delayed: return wanted;
    }
    return wanted;
}

void SocketLoop::sweep() {
    if (acceptAgain_ && now_ >= *acceptAgain_ && !stopping_) listenAgain();
    if (notesLeftOut_ > 0 && noteRate_.take(1.0, wallSeconds()))
        log().info("{} more connections, not told one by one", std::exchange(notesLeftOut_, 0));
    std::vector<uint64_t> ids;
    ids.reserve(channels_.size());
    for (const auto& [id, channel] : channels_) ids.push_back(id);
    for (uint64_t id : ids) {
        auto found = channels_.find(id);
        if (found == channels_.end()) continue;
        if (!inTime(*found->second)) drop(id);
        else if (found->second->hasOutput() && !found->second->blocked()) serve(id, 0);
    }
}

/// False when the connection is over its time.
bool SocketLoop::inTime(Channel& channel) {
    const auto age = now_ - channel.since, silence = now_ - channel.lastRead;
    const SocketTimes& times = options_.times;
    auto cut = [&](uint16_t code, const char* why) {
        channel.closeCode = code;
        channel.reason = why;
        channel.transport.resetOnClose();
        return false;
    };
    if (channel.stalled(now_, times.write)) return cut(static_cast<uint16_t>(CloseCode::stalled), "what was sent is not read");
    switch (channel.phase) {
        case Phase::request: {
            const bool first = channel.accepted == channel.since;
            if (channel.arrived.empty() && !first) return age < times.keepAlive || cut(0, "idle");
            if (age < times.request) return true;
            if (channel.arrived.empty()) return cut(0, "no request");
            refuse(channel, refusal(408, "the request was not whole in time"));
            return true;
        }
        case Phase::delayed:
            if (now_ < channel.due) return true;
            channel.enter(Phase::answer, now_);
            if (channel.closesLate) channel.farewell(static_cast<uint16_t>(CloseCode::unauthorized), "wrong token", now_);
            return true;
        case Phase::guest:
            if (age < times.token) return true;
            channel.farewell(static_cast<uint16_t>(CloseCode::unauthorized), "no token within 5 seconds", now_);
            return true;
        case Phase::viewer:
            if (!channel.closeAsked && channel.connection->closeAsked()) channel.closeAsked = now_;
            if (channel.closeAsked && now_ - *channel.closeAsked > times.close)
                return cut(static_cast<uint16_t>(CloseCode::stalled), "what was sent is not read");
            if (silence > IDLE_CLOSE) return cut(0, "silent");
            if (silence > IDLE_PING && !std::exchange(channel.pinged, true)) channel.say(controlFrame(Opcode::ping, ""));
            return true;
        case Phase::leaving: {
            const bool out = !channel.hasOutput();
            if (!out && age > times.close) channel.transport.resetOnClose();
            return out ? age < LINGER : age <= times.close;
        }
        case Phase::answer: return true;
    }
    return true;
}

void SocketLoop::drop(uint64_t id) {
    auto found = channels_.find(id);
    if (found == channels_.end()) return;
    const std::unique_ptr<Channel> channel = std::move(found->second);
    channels_.erase(found);
    if (auto count = perAddress_.find(channel->peer.key); count != perAddress_.end() && --count->second == 0)
        perAddress_.erase(count);
    if (!channel->connection) return;
    viewerCount_--;
    const double seconds = std::chrono::duration<double>(now_ - channel->accepted).count();
    const std::string code = channel->closeCode ? std::to_string(channel->closeCode) + " " : "";
    note(*channel, LogLevel::info,
         fmt::format("closed: {}{}; {:.1f} s, {} bytes in, {} out", code, channel->reason, seconds, channel->received,
                     channel->sent));
    channel->connection->disconnect();
    if (!channel->connection->peer) return;
    try {
        handler_.ended(channel->closeCode, channel->reason);
        std::optional<CloseCode> code;
        if (channel->closeCode != 0 && !channel->theyClosed) code = static_cast<CloseCode>(channel->closeCode);
        handler_.closed(std::exchange(channel->connection->peer, nullptr), code);
    } catch (const std::exception& e) {
        log().error("connection of {}: {}", channel->peer.text, e.what());
    }
}

}  // namespace heliograph

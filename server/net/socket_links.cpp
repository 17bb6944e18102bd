// How the socket loop keeps connections from taking more than they should: how many, whose, and for how long.

#include "server/base/clock.h"
#include "server/base/log.h"
#include "server/net/listen/descriptors.h"
#include "server/net/guard/tcp_counts.h"
#include "server/net/socket_loop.h"

#include <unistd.h>

#include <algorithm>

namespace heliograph {

namespace {

double secondsOf(std::chrono::steady_clock::time_point time) {
    return std::chrono::duration<double>(time.time_since_epoch()).count();
}

}  // namespace

void SocketLoop::checkDescriptors() {
    constexpr size_t OTHERS = 64;  // files, devices, pipes
    const size_t connections = options_.maxViewers + options_.spareConnections, more = RESERVED_CONNECTIONS + OTHERS;
    const size_t limit = raiseDescriptorLimit(connections + more);
    room_ = std::min(connections, limit > 2 * more ? limit - more : limit / 2);
    log().info("limits of connections: {} beside {} viewers, {} of one address; {} guests", options_.spareConnections,
               options_.maxViewers, options_.spareConnectionsPerAddress, options_.maxGuests);
    if (room_ == connections) return;
    log().warn("{} descriptors are allowed (ulimit -n), {} wanted: room for {} connections", limit, connections + more, room_);
}

/// Without descriptors listening sockets stay readable and every turn of the loop would try in vain: then none is looked at
/// for a while.
void SocketLoop::pauseListening() {
    constexpr auto PAUSE = std::chrono::seconds(1);
    if (listensAgain_) return;
    for (const Door& door : doors_) lws_rx_flow_control(door.wsi, 0);
    listensAgain_ = Clock::now() + PAUSE;
    if (std::exchange(pauseSaid_, true)) return;
    log().error("no connection can be accepted for now: no descriptors are left; {} connections are open (ulimit -n)",
                links_.size());
}

void SocketLoop::listenAgain() {
    if (!listensAgain_ || Clock::now() < *listensAgain_) return;
    listensAgain_.reset();
    for (const Door& door : doors_) lws_rx_flow_control(door.wsi, 1);
}

/// Somebody waits at the door of `wsi`.
void SocketLoop::takeConnections(lws* wsi) {
    constexpr int AT_ONCE = 16;  // then others have their turn
    const auto door = std::ranges::find(doors_, wsi, &Door::wsi);
    for (int i = 0; door != doors_.end() && i < AT_ONCE; i++) {
        const Accepted accepted = door->listener.accept();
        if (accepted.outOfMeans()) return pauseListening();
        if (accepted.descriptor < 0) return;
        take(*door, accepted);
    }
}

void SocketLoop::take(const Door& door, const Accepted& accepted) {
    if (!connects(accepted)) {
        ::close(accepted.descriptor);
        return;
    }
    door_ = &door;
    accepted_ = &accepted;
    lws_sock_file_fd_type socket{};
    socket.sockfd = accepted.descriptor;
    // What goes over a unix socket does not leave the machine: TLS is for the others.
    const int tls = accepted.overUnix() ? 0 : LWS_ADOPT_ALLOW_SSL;
    // Closes the socket where it fails.
    lws_adopt_descriptor_vhost(host_, static_cast<lws_adoption_type>(LWS_ADOPT_SOCKET | LWS_ADOPT_HTTP | tls), socket, nullptr,
                               nullptr);
    door_ = nullptr;
    accepted_ = nullptr;
}

/// Someone wants to connect: false turns it away. Where there is no room, an idle connection gives way.
bool SocketLoop::connects(const Accepted& accepted) {
    const std::string& address = accepted.address;
    const auto stays = [](const auto& link) { return !link.second.leaving; };
    const auto ofAddress = [&](const auto& link) { return stays(link) && link.second.address == address; };
    const auto all = static_cast<size_t>(std::ranges::count_if(links_, stays));
    const auto ours = static_cast<size_t>(std::ranges::count_if(links_, ofAddress));
    const size_t most = std::min(options_.maxViewers + options_.spareConnections, room_);
    // Who comes over a unix socket comes from a proxy for many, or may do all here anyway.
    const bool manyOfAddress = !accepted.overUnix() && ours >= options_.maxViewers + options_.spareConnectionsPerAddress;
    reserveNext_ = false;
    if (!manyOfAddress && all < most) return true;
    if (auto victim = whoGivesWay(waiting(false), manyOfAddress ? address : "")) {
        auto* wsi = reinterpret_cast<lws*>(*victim);
        Link& link = links_.at(wsi);
        link.leaving = true;
        reserveNext_ = link.reserved;
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
        return true;
    }
    reserveNext_ = true;
    if (all < most + RESERVED_CONNECTIONS) return true;
    handler_.refused(503, "too many connections");
    return false;
}

void SocketLoop::connected(lws* wsi) {
    pauseSaid_ = false;
    const auto now = Clock::now();
    Link link{accepted_->address, ofThisMachine(door_->listener.address()), now, WriteWatch(now)};
    link.reserved = reserveNext_;
    links_.insert_or_assign(wsi, std::move(link));
}

void SocketLoop::countWritten(lws* wsi, size_t bytes) {
    if (const auto link = links_.find(wsi); link != links_.end()) link->second.written += bytes;
}

/// Grows with what the other side takes.
uint64_t SocketLoop::takenBytes(lws* wsi) {
    const int descriptor = lws_get_socket_fd(wsi);
    const auto link = links_.find(wsi);
    if (link == links_.end() || !link->second.overUnix()) return acknowledgedBytes(descriptor);
    return link->second.progress.taken(link->second.written, heldBytes(descriptor));
}

/// Connections that no viewer looks through: those on HTTP, or the guests.
std::vector<Waiting> SocketLoop::waiting(bool guests) const {
    std::vector<Waiting> all;
    for (const auto& [wsi, link] : links_) {
        if (link.leaving) continue;
        const auto viewer = viewers_.find(wsi);
        const bool isGuest = viewer != viewers_.end() && viewer->second.guest && !viewer->second.connection->closeAsked();
        if (guests ? !isGuest : viewer != viewers_.end()) continue;
        const std::string_view address = link.overUnix() ? std::string_view() : link.address;
        all.push_back({reinterpret_cast<uintptr_t>(wsi), address, answers_.contains(wsi), secondsOf(link.since)});
    }
    return all;
}

void SocketLoop::makeRoomForGuest() {
    const std::vector<Waiting> guests = waiting(true);
    if (guests.size() < options_.maxGuests) return;
    if (auto leaving = whichGuestLeaves(guests)) {
        viewers_.at(reinterpret_cast<lws*>(*leaving))
            .connection->close(CloseCode::tryAgainLater, "gave way to a newer connection; say the token sooner");
    }
}

/// A line of the access log; of too many a second only the number is told.
void SocketLoop::note(lws* wsi, const std::string& what, std::optional<CloseCode> code) {
    if (!notes_.take(1.0, wallSeconds())) {
        notesLeftOut_++;
        return;
    }
    const std::string address = addressOf(wsi);
    nlohmann::ordered_json fields = {{"address", address}};
    if (code) fields["code"] = static_cast<int>(*code);
    logWith(LogLevel::info, address + ": " + what + (code ? ", code " + std::to_string(static_cast<int>(*code)) : ""),
            std::move(fields));
}

/// Lets go of who does not take the answer it asked for.
void SocketLoop::sweepLinks() {
    if (notesLeftOut_ > 0 && notes_.take(1.0, wallSeconds()))
        log().info("{} more lines about connections left out", std::exchange(notesLeftOut_, 0));
    sweepUploads();
    const auto now = Clock::now();
    for (auto& [wsi, link] : links_) {
        if (viewers_.contains(wsi) || link.leaving) continue;
        const bool waits = answers_.contains(wsi) || lws_partial_buffered(wsi);
        const int descriptor = lws_get_socket_fd(wsi);
        if (!waits || descriptor < 0) {
            link.writes = WriteWatch(now);
            continue;
        }
        if (!link.writes.stalled(now, waits, takenBytes(wsi), options_.times.write)) continue;
        link.leaving = true;
        lws_set_timeout(wsi, PENDING_TIMEOUT_USER_REASON_BASE, LWS_TO_KILL_ASYNC);
    }
}

}  // namespace heliograph

#include "server/net/channel.h"

#include "server/base/clock.h"

namespace heliograph {

static_assert(SOCKET_HEADROOM >= FRAME_HEAD_BYTES);

namespace {

constexpr size_t READ_AT_ONCE = 65536, WRITE_AT_ONCE = 1 << 20;  // bytes; then it is another connection's turn
constexpr size_t WRITE_FLOOR = 4096;                             // bytes in WRITE_WINDOW

std::span<const uint8_t> bytesOf(std::string_view text) { return {reinterpret_cast<const uint8_t*>(text.data()), text.size()}; }

}  // namespace

Channel::Channel(uint64_t number, int descriptor, PeerAddress address, TlsContext tls, Clock::time_point now)
    : id(number), peer(std::move(address)), accepted(now), transport(descriptor, std::move(tls)), since(now), lastRead(now) {}

void Channel::enter(Phase next, Clock::time_point now) {
    phase = next;
    since = now;
}

bool Channel::receive(Clock::time_point now) {
    uint8_t bytes[16384];
    for (size_t all = 0; all < READ_AT_ONCE;) {
        const Transport::Moved moved = transport.read(bytes);
        arrived.append(reinterpret_cast<const char*>(bytes), moved.bytes);
        all += moved.bytes;
        received += moved.bytes;
        if (moved.bytes > 0) lastRead = now;
        if (moved.bytes > 0) pinged = false;
        if (moved.state == Transport::State::closed) return false;
        if (moved.state == Transport::State::wait) return true;
    }
    return true;
}

void Channel::answer(HttpAnswer given, bool keep, bool withBody) {
    answer_ = std::move(given);
    keepAlive = keep;
    say(headOf(answer_, keep));
    bodyWaits_ = withBody && !answer_.body().empty();
}

void Channel::pong(std::span<const uint8_t> payload) {
    // Of several pings that wait for an answer only the newest gets one.
    pong_ = controlFrame(Opcode::pong, {reinterpret_cast<const char*>(payload.data()), payload.size()});
}

void Channel::farewell(uint16_t code, const std::string& why, Clock::time_point now) {
    if (saidFarewell_) return;
    saidFarewell_ = true;
    closeCode = code;
    reason = why;
    pong_.clear();
    say(closeFrame(code, why));
    // Who floods or breaks the rules is not listened to any more; others are, so that they can read to the end.
    discards = code != 1002 && code != 1007 && code != 1008 && code != 1009;
    enter(Phase::leaving, now);
}

bool Channel::hasOutput() const {
    if (!pending_.empty() || !out_.empty() || !pong_.empty() || bodyWaits_) return true;
    return phase == Phase::viewer && connection && connection->hasOutput();
}

bool Channel::nextOutput(Clock::time_point now) {
    if (phase == Phase::delayed) return false;
    if (out_.empty()) out_ = std::exchange(pong_, {});
    if (!out_.empty()) {
        writing_ = std::exchange(out_, {});
        pending_ = bytesOf(writing_);
    } else if (bodyWaits_) {
        bodyWaits_ = false;
        pending_ = bytesOf(answer_.body());
    } else if (phase == Phase::viewer && connection) {
        if (auto closing = connection->closing()) {
            farewell(static_cast<uint16_t>(closing->code), closing->reason, now);
            return nextOutput(now);
        }
        auto piece = connection->nextPiece(now);
        if (!piece) return false;
        const Opcode opcode = !piece->first ? Opcode::continuation : piece->text ? Opcode::text : Opcode::binary;
        uint8_t* begin = writeFrameHead(piece->bytes.data(), opcode, piece->last, piece->bytes.size());
        pending_ = {begin, piece->bytes.data() + piece->bytes.size()};
        pieceBegun_ = !piece->text;
        pieceSeconds_ = 0.0;
    } else {
        return false;
    }
    windowSince_ = progress_ = now;
    windowBytes_ = 0;
    return true;
}

void Channel::pieceDone() {
    if (!std::exchange(pieceBegun_, false)) return;
    if (connection) connection->pieceWritten(pieceSeconds_);
}

bool Channel::flush(Clock::time_point now) {
    for (size_t all = 0; all < WRITE_AT_ONCE;) {
        if (pending_.empty() && !nextOutput(now)) return true;
        const double before = pieceBegun_ ? threadCpuSeconds() : 0.0;
        const Transport::Moved moved = transport.write(pending_);
        if (pieceBegun_) pieceSeconds_ += threadCpuSeconds() - before;
        if (moved.state == Transport::State::closed) return false;
        if (moved.bytes == 0) return true;
        pending_ = pending_.subspan(moved.bytes);
        all += moved.bytes;
        sent += moved.bytes;
        windowBytes_ += moved.bytes;
        progress_ = now;
        if (pending_.empty()) pieceDone();
    }
    return true;
}

bool Channel::stalled(Clock::time_point now, std::chrono::milliseconds window) {
    if (!blocked()) return false;
    if (now - progress_ >= window) return true;
    if (now - windowSince_ < window) return false;
    const bool tooLittle = windowBytes_ < WRITE_FLOOR;
    windowSince_ = now;
    windowBytes_ = 0;
    return tooLittle;
}

}  // namespace heliograph

#pragma once
// One accepted connection while it lasts: what arrived and is not read yet, what waits to be written, and since when. First it
// speaks HTTP, then maybe WebSocket. Moves bytes only; socket_server decides. The socket's thread alone.

#include "server/net/connection.h"
#include "server/net/http_answers.h"
#include "server/net/web/frames.h"
#include "server/net/web/listener.h"
#include "server/net/web/transport.h"

namespace heliograph {

class Channel {
public:
    using Clock = std::chrono::steady_clock;
    enum class Phase {
        request,  // waits for a request, or for the rest of one
        answer,   // is being answered
        delayed,  // the answer waits for its time
        guest,    // WebSocket, without the token yet
        viewer,   // WebSocket with a session
        leaving,  // what waits is written, then it ends
    };

    Channel(uint64_t id, int descriptor, PeerAddress peer, TlsContext tls, Clock::time_point now);

    /// Reads what has arrived, at most 64 KiB, to the end of `arrived`. False when the other side has ended.
    bool receive(Clock::time_point now);
    /// Writes what waits, as far as the other side takes it. False when it has gone.
    bool flush(Clock::time_point now);
    /// Something waits to be written and the other side does not take it.
    bool blocked() const { return !pending_.empty(); }
    bool hasOutput() const;
    /// For so long (WRITE_WINDOW) it took next to nothing of what waits.
    bool stalled(Clock::time_point now, std::chrono::milliseconds window);

    void enter(Phase phase, Clock::time_point now);
    void answer(HttpAnswer answer, bool keepAlive, bool withBody);
    /// Bytes at the next boundary between frames or answers.
    void say(std::string bytes) { out_ += bytes; }
    void pong(std::span<const uint8_t> payload);
    /// A close frame goes out after what is being written; nothing else does.
    void farewell(uint16_t code, const std::string& reason, Clock::time_point now);

    bool isWebSocket() const { return phase == Phase::guest || phase == Phase::viewer; }

    const uint64_t id;
    const PeerAddress peer;
    const Clock::time_point accepted;
    Transport transport;
    Phase phase = Phase::request;
    Clock::time_point since;     // of the phase
    Clock::time_point due{};     // of a delayed answer
    Clock::time_point lastRead;  // when something arrived
    bool local = false;          // came in where only this machine can
    bool reserved = false;       // beyond the limit: only health is told
    bool ended = false;          // the other side sends nothing more
    bool keepAlive = true;       // after the answer
    bool closesLate = false;     // after the delay: a wrong token of a guest
    bool discards = false;       // while leaving: reads on, so that the other side can read what was written
    bool pinged = false;
    bool writingEnded = false;
    Scope scope = Scope::none;
    uint32_t events = 0;  // that the system is asked for

    std::string arrived;
    FrameReader frames;
    std::string message;                     // of a guest, as far as it has come
    std::shared_ptr<Connection> connection;  // of a viewer
    std::string reason = "hung up";          // why it ends, for the log
    uint16_t closeCode = 0;                  // that was sent or came
    bool theyClosed = false;                 // it came
    std::optional<Clock::time_point> closeAsked;
    uint64_t received = 0, sent = 0;  // bytes

private:
    bool nextOutput(Clock::time_point now);
    void pieceDone();

    std::string out_, writing_;  // waits; is being written
    std::string pong_;
    bool saidFarewell_ = false;
    HttpAnswer answer_;
    bool bodyWaits_ = false;
    std::span<const uint8_t> pending_;  // of writing_, the answer's body or a piece of the connection
    bool pieceBegun_ = false;
    double pieceSeconds_ = 0.0;
    Clock::time_point windowSince_{}, progress_{};
    size_t windowBytes_ = 0;
};

}  // namespace heliograph

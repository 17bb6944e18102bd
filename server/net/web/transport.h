#pragma once
// The bytes of one accepted connection, with or without TLS; never waits.

#include "server/net/web/tls.h"

#include <cstdint>
#include <span>

struct ssl_st;

namespace heliograph {

class Transport {
public:
    /// Takes the descriptor over. With a context, the handshake happens while reading. Throws std::bad_alloc.
    Transport(int descriptor, TlsContext tls);
    ~Transport();
    Transport(const Transport&) = delete;

    enum class State { open, wait, closed };
    /// What was done, and whether more can be done now.
    struct Moved {
        size_t bytes = 0;
        State state = State::open;
    };
    Moved read(std::span<uint8_t> bytes);
    Moved write(std::span<const uint8_t> bytes);

    /// There are bytes that arrived but were not asked for, of which the system tells nothing any more.
    bool hasUnread() const;
    /// The handshake goes on when something can be written.
    bool handshakeWrites() const { return handshakeWrites_; }
    /// Nothing more is sent; the other side is told.
    void endWriting();
    /// Closing discards what waits to be sent and tells the other side at once.
    void resetOnClose() const;
    int descriptor() const { return descriptor_; }

private:
    Moved outcome(int result);

    const int descriptor_;
    const TlsContext tls_;
    ssl_st* ssl_ = nullptr;
    bool handshakeWrites_ = false;
};

}  // namespace heliograph

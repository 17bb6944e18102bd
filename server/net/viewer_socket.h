#pragma once
// The connection to one viewer as its session sees it. socket_server.h implements it over libwebsockets, tests over memory.

#include "server/net/protocol.h"

#include <chrono>
#include <vector>

namespace heliograph {

/// Bytes that the transport may overwrite in front of a message.
constexpr size_t SOCKET_HEADROOM = 32;

/// A frame or a picture: SOCKET_HEADROOM bytes, the header, the payload.
struct OutgoingPicture {
    std::vector<uint8_t> bytes;
    FrameKind kind = FrameKind::frame;
    uint32_t frameId = 0;
    std::chrono::steady_clock::time_point encoded{};  // the header's `sendMicros` counts from here
};

/// Safe from all threads. After the connection has gone all calls do nothing.
class ViewerSocket {
public:
    virtual ~ViewerSocket() = default;
    virtual void sendText(std::string text) = 0;
    /// A frame replaces a frame of which no byte has been written yet and returns that one's id; the viewer will never
    /// see it. Pictures are never replaced.
    virtual std::optional<uint32_t> sendPicture(OutgoingPicture picture) = 0;
    /// Sends what waits as text, then closes.
    virtual void close(CloseCode code, const std::string& reason) = 0;
    /// Where the viewer connects from; empty where that is not known.
    virtual std::string address() const { return {}; }
};

/// The other side: what the socket tells the session. Called from the socket's thread only.
class ViewerPeer {
public:
    virtual ~ViewerPeer() = default;
    /// A text message came.
    virtual void receive(std::string_view text) = 0;
    /// The viewer closes: it leaves on purpose, its line is not broken.
    virtual void leaves() {}
    /// A frame or picture left for the viewer: seconds since it was encoded, and processor seconds spent handing it to the system.
    virtual void written(FrameKind kind, double waitSeconds, double writeSeconds) = 0;
};

}  // namespace heliograph

#pragma once
// One WebSocket connection: what waits to be written, and the pieces of the message that is just arriving. Knows nothing
// of libwebsockets; socket_server moves its bytes.

#include "server/net/guard/rate_limit.h"
#include "server/net/viewer_socket.h"

#include <deque>
#include <functional>
#include <memory>
#include <mutex>

namespace heliograph {

class Connection : public ViewerSocket {
public:
    /// `wake` is called, from any thread, when there is something to write.
    explicit Connection(std::function<void()> wake, std::string address = {})
        : wake_(std::move(wake)), address_(std::move(address)) {}

    void sendText(std::string text) override;
    std::optional<uint32_t> sendPicture(OutgoingPicture picture) override;
    void close(CloseCode code, const std::string& reason) override;
    std::string address() const override { return address_; }

    // The rest is for the socket's thread.

    /// The next piece to write: `bytes` has SOCKET_HEADROOM writable bytes before it and stays valid until the next call.
    struct Piece {
        std::span<uint8_t> bytes;
        bool text = false;
        bool first = true;  // of its message
        bool last = true;
    };
    std::optional<Piece> nextPiece(std::chrono::steady_clock::time_point now);
    /// The piece was handed to the system, which took `seconds` of the processor. Tells the peer of a picture that has left.
    void pieceWritten(double seconds);
    bool hasOutput() const;
    /// Set when all text is out and the connection is to be closed.
    struct Closing {
        CloseCode code;
        std::string reason;
    };
    std::optional<Closing> closing() const;
    /// It is to be closed with this code, maybe after what is just being written.
    std::optional<CloseCode> closeAsked() const;

    /// Takes a piece of an incoming message. Returns the code to close with if the message breaks a rule.
    std::optional<CloseCode> receive(std::string_view piece, bool binary, bool last, double now);
    /// Counts what came beside messages: fragments, pings. False where it is more than messages may be.
    bool countMessages(double count, double now) { return messages_.take(count, now); }
    /// The connection has gone: nothing is kept or sent any more.
    void disconnect();

    std::shared_ptr<ViewerPeer> peer;
    std::optional<CloseCode> closedWith;  // the code that the server gave; nothing while it is open and where the viewer leaves

private:
    static constexpr size_t PIECE_BYTES = 256 * 1024;  // of a picture, so that nothing is copied whole

    const std::function<void()> wake_;
    const std::string address_;
    mutable std::mutex mutex_;
    std::deque<std::string> texts_;  // with headroom
    size_t textBytes_ = 0;
    std::optional<OutgoingPicture> frame_;
    std::deque<OutgoingPicture> pictures_;
    std::optional<Closing> closing_;
    bool gone_ = false;

    // The socket's thread alone.
    std::string text_;                        // being written
    std::optional<OutgoingPicture> current_;  // being written
    size_t offset_ = 0;
    double waited_ = 0.0, writing_ = 0.0;  // seconds
    std::string incoming_;
    RateLimit messages_{MESSAGE_RATE, MESSAGE_BURST};
    RateLimit bytes_{BYTE_RATE, BYTE_BURST};
};

}  // namespace heliograph

#pragma once
// A small HTTP and WebSocket client over a blocking socket, for tests of the server: it also says things that a browser
// never would.

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace heliograph::test {

/// Answer to an HTTP request, as it came.
struct HttpAnswer {
    int status = 0;
    std::string head;  // status line and headers
    std::string body;
    /// Value of a header by its lower-case name; empty where it lacks.
    std::string header(const std::string& name) const;
};

/// Message of a WebSocket. opcode: 1 text, 2 binary, 8 close.
struct WebMessage {
    int opcode = 0;
    std::string bytes;
    /// Of a close message.
    int closeCode() const;
};

/// A WebSocket frame, masked as those of clients have to be. `last` false: a fragment. opcode 0 continues one.
std::string maskedFrame(int opcode, const std::string& bytes, bool last = true);

class WebClient {
public:
    /// Connects to 127.0.0.1, from another address of this machine if one is given. Reading waits at most 20 s; `receiveBuffer`
    /// bytes of the system, where it is not 0. Throws std::runtime_error.
    explicit WebClient(int port, const char* from = nullptr, int receiveBuffer = 0);
    /// Connects to a unix socket.
    explicit WebClient(const std::string& path);
    ~WebClient();
    WebClient(const WebClient&) = delete;

    /// Sends the bytes as they are.
    void send(const std::string& bytes);
    /// `GET path` with more header lines ("Name: value\r\n").
    HttpAnswer get(const std::string& path, const std::string& headers = {});
    /// Asks for the WebSocket at `path`; status 101 when it is open.
    HttpAnswer upgrade(const std::string& headers, const std::string& path = "/ws");
    HttpAnswer readAnswer();
    /// Waits until the server has closed; false if it sends something instead.
    bool untilClosed();
    /// Sends the bytes again and again until the connection has ended or takes nothing for 20 s. `sent`: how many were taken,
    /// by the system's buffers among others. From another thread than receive().
    void flood(const std::string& bytes, std::atomic<size_t>& sent);
    /// Takes at most so many bytes of what is there, and forgets them. Returns how many.
    size_t take(size_t most);

    /// As maskedFrame.
    void sendFrame(int opcode, const std::string& bytes, bool last = true) { send(maskedFrame(opcode, bytes, last)); }
    void sendText(const std::string& text) { sendFrame(1, text); }
    /// The next message, its fragments put together; pings are answered. Nothing when the connection has ended.
    std::optional<WebMessage> receive();

private:
    bool fill();
    bool need(size_t bytes);

    int fd_ = -1;
    std::string buffer_;
};

}  // namespace heliograph::test

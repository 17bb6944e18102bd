#include "tests/support/web_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <stdexcept>

namespace heliograph::test {

std::string HttpAnswer::header(const std::string& name) const {
    std::string lower = head;
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
    size_t at = lower.find("\r\n" + name + ":");
    if (at == std::string::npos) return {};
    size_t begin = head.find_first_not_of(' ', at + 3 + name.size());
    return head.substr(begin, head.find("\r\n", begin) - begin);
}

int WebMessage::closeCode() const {
    if (opcode != 8 || bytes.size() < 2) return 0;
    return static_cast<uint8_t>(bytes[0]) << 8 | static_cast<uint8_t>(bytes[1]);
}

namespace {

int patientSocket(int family) {
    const int fd = socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    timeval patience{20, 0};
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    return fd;
}

}  // namespace

WebClient::WebClient(const std::string& path) : fd_(patientSocket(AF_UNIX)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    if (connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) throw std::runtime_error("cannot connect");
}

bool WebClient::untilClosed() {
    char byte;
    return buffer_.empty() && recv(fd_, &byte, 1, 0) <= 0 && errno != EAGAIN;
}

void WebClient::flood(const std::string& bytes, std::atomic<size_t>& sent) {
    constexpr int PATIENCE = 20'000;  // ms
    while (true) {
        const size_t at = sent % bytes.size();
        const ssize_t count = ::send(fd_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL | MSG_DONTWAIT);
        pollfd writable{fd_, POLLOUT, 0};
        if (count > 0) sent += static_cast<size_t>(count);
        else if (errno != EAGAIN || poll(&writable, 1, PATIENCE) <= 0) return;
    }
}

size_t WebClient::take(size_t most) {
    std::string bytes(most, '\0');
    const ssize_t count = recv(fd_, bytes.data(), most, MSG_DONTWAIT);
    return count > 0 ? static_cast<size_t>(count) : 0;
}

WebClient::WebClient(int port, const char* from, int receiveBuffer) : fd_(patientSocket(AF_INET)) {
    if (receiveBuffer > 0) setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receiveBuffer, sizeof receiveBuffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    if (from) {
        inet_pton(AF_INET, from, &address.sin_addr);
        if (bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) throw std::runtime_error("cannot bind");
    }
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) throw std::runtime_error("cannot connect");
}

WebClient::~WebClient() { ::close(fd_); }

void WebClient::send(const std::string& bytes) {
    for (size_t sent = 0; sent < bytes.size();) {
        ssize_t count = ::send(fd_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (count <= 0) return;  // the server has closed; receive() tells
        sent += static_cast<size_t>(count);
    }
}

bool WebClient::fill() {
    char bytes[65536];
    ssize_t count = recv(fd_, bytes, sizeof bytes, 0);
    if (count <= 0) return false;
    buffer_.append(bytes, static_cast<size_t>(count));
    return true;
}

bool WebClient::need(size_t bytes) {
    while (buffer_.size() < bytes) {
        if (!fill()) return false;
    }
    return true;
}

HttpAnswer WebClient::readAnswer() {
    HttpAnswer answer;
    size_t end;
    while ((end = buffer_.find("\r\n\r\n")) == std::string::npos) {
        if (!fill()) return answer;
    }
    answer.head = buffer_.substr(0, end + 2);
    buffer_.erase(0, end + 4);
    answer.status = std::stoi(answer.head.substr(answer.head.find(' ') + 1));
    std::string length = answer.header("content-length");
    if (!length.empty() && need(std::stoul(length))) {
        answer.body = buffer_.substr(0, std::stoul(length));
        buffer_.erase(0, answer.body.size());
    }
    return answer;
}

HttpAnswer WebClient::get(const std::string& path, const std::string& headers) {
    send("GET " + path + " HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n");
    return readAnswer();
}

HttpAnswer WebClient::upgrade(const std::string& headers, const std::string& path) {
    return get(path,
               "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                   headers);
}

std::string maskedFrame(int opcode, const std::string& bytes, bool last) {
    std::string frame(1, static_cast<char>((last ? 0x80 : 0) | opcode));
    if (bytes.size() < 126) {
        frame += static_cast<char>(0x80 | bytes.size());
    } else if (bytes.size() < 65536) {
        frame += static_cast<char>(0x80 | 126);
        for (int shift : {8, 0}) frame += static_cast<char>(bytes.size() >> shift);
    } else {
        frame += static_cast<char>(0x80 | 127);
        for (int shift = 56; shift >= 0; shift -= 8) frame += static_cast<char>(bytes.size() >> shift);
    }
    const char mask[4] = {1, 2, 3, 4};
    frame.append(mask, 4);
    for (size_t i = 0; i < bytes.size(); i++) frame += static_cast<char>(bytes[i] ^ mask[i % 4]);
    return frame;
}

std::optional<WebMessage> WebClient::receive() {
    WebMessage message;
    for (;;) {
        if (!need(2)) return std::nullopt;
        const bool last = buffer_[0] & 0x80;
        const int opcode = buffer_[0] & 0x0f;
        size_t length = buffer_[1] & 0x7f, head = 2;
        if (length >= 126) {
            const size_t bytes = length == 126 ? 2 : 8;
            if (!need(2 + bytes)) return std::nullopt;
            length = 0;
            for (size_t i = 0; i < bytes; i++) length = length << 8 | static_cast<uint8_t>(buffer_[2 + i]);
            head += bytes;
        }
        if (!need(head + length)) return std::nullopt;
        std::string payload = buffer_.substr(head, length);
        buffer_.erase(0, head + length);
        if (opcode == 9) {
            sendFrame(10, payload);
            continue;
        }
        if (opcode == 10) continue;
        if (opcode != 0) message.opcode = opcode;
        message.bytes += payload;
        if (last) return message;
    }
}

}  // namespace heliograph::test

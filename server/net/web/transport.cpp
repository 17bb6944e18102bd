#include "server/net/web/transport.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <new>

namespace heliograph {

namespace {

int bounded(size_t bytes) { return static_cast<int>(std::min<size_t>(bytes, INT_MAX)); }

Transport::Moved plain(ssize_t result) {
    if (result > 0) return {static_cast<size_t>(result), Transport::State::open};
    if (result < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return {0, Transport::State::wait};
    return {0, Transport::State::closed};
}

}  // namespace

Transport::Transport(int descriptor, TlsContext tls) : descriptor_(descriptor), tls_(std::move(tls)) {
    if (!tls_) return;
    ssl_ = SSL_new(tls_.get());
    if (!ssl_ || SSL_set_fd(ssl_, descriptor_) != 1) {
        SSL_free(ssl_);
        ::close(descriptor_);
        throw std::bad_alloc();
    }
    SSL_set_accept_state(ssl_);
}

Transport::~Transport() {
    SSL_free(ssl_);
    ::close(descriptor_);
}

Transport::Moved Transport::outcome(int result) {
    if (result > 0) return {static_cast<size_t>(result), State::open};
    const int error = SSL_get_error(ssl_, result);
    if (error == SSL_ERROR_WANT_READ) return {0, State::wait};
    if (error == SSL_ERROR_WANT_WRITE) {
        handshakeWrites_ = !SSL_is_init_finished(ssl_);
        return {0, State::wait};
    }
    return {0, State::closed};
}

Transport::Moved Transport::read(std::span<uint8_t> bytes) {
    if (!ssl_) return plain(::recv(descriptor_, bytes.data(), bytes.size(), 0));
    handshakeWrites_ = false;
    ERR_clear_error();
    return outcome(SSL_read(ssl_, bytes.data(), bounded(bytes.size())));
}

Transport::Moved Transport::write(std::span<const uint8_t> bytes) {
    if (!ssl_) return plain(::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    ERR_clear_error();
    return outcome(SSL_write(ssl_, bytes.data(), bounded(bytes.size())));
}

bool Transport::hasUnread() const { return ssl_ && SSL_has_pending(ssl_); }

void Transport::endWriting() {
    if (ssl_ && SSL_is_init_finished(ssl_)) {
        ERR_clear_error();
        SSL_shutdown(ssl_);
    }
    ::shutdown(descriptor_, SHUT_WR);
}

void Transport::resetOnClose() const {
    const linger now{1, 0};
    setsockopt(descriptor_, SOL_SOCKET, SO_LINGER, &now, sizeof now);
}

}  // namespace heliograph

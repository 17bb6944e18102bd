#include "server/net/socket_server.h"

#include "server/net/socket_loop.h"

#include <thread>

namespace heliograph {

class SocketServer::Impl {
public:
    Impl(SocketOptions options, SocketHandler& handler) : loop(std::move(options), handler) {}
    ~Impl() { stop(); }

    void stop() {
        if (!thread.joinable()) return;
        loop.stop();
        thread.join();
    }

    SocketLoop loop;
    std::thread thread;
};

SocketServer::SocketServer(SocketOptions options, SocketHandler& handler)
    : impl_(std::make_unique<Impl>(std::move(options), handler)) {}
SocketServer::~SocketServer() = default;
int SocketServer::port() const { return impl_->loop.listeners().front().address().port; }
void SocketServer::stop() { impl_->stop(); }
void SocketServer::wake() { impl_->loop.wake(); }
void SocketServer::reload(const SocketAccess& access) { impl_->loop.reload(access); }
void SocketServer::drain(bool draining) { impl_->loop.drain(draining); }

void SocketServer::start() {
    impl_->thread = std::thread([this] { impl_->loop.run(); });
}

std::string SocketServer::url() const {
    const std::string all = urls();
    return all.substr(0, all.find(", "));
}

std::string SocketServer::urls() const {
    std::string all;
    for (const Listener& listener : impl_->loop.listeners()) {
        const std::string address = listener.address().text(), scheme = impl_->loop.secure() ? "https://" : "http://";
        all += (all.empty() ? "" : ", ") + (listener.address().path.empty() ? scheme + address : address);
    }
    return all;
}

}  // namespace heliograph

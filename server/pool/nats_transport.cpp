#include "server/pool/nats_transport.h"

#include "server/base/error.h"
#include "server/base/log.h"
#include "server/base/text.h"
#include "server/pool/nats_library.h"
#include "server/pool/wire/subjects.h"

#include <atomic>
#include <charconv>
#include <future>
#include <stdexcept>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

// Milliseconds.
constexpr int64_t CONNECT_TIMEOUT = 2000, WRITE_DEADLINE = 500, PING_EVERY = 1000, RECONNECT_WAIT = 250, JITTER = 100;
constexpr int MOST_PINGS_OUT = 2;
/// What is said while there is no line is stale when it is back.
constexpr int RECONNECT_BYTES = 1024;
/// Read at once: results come in messages of 128 KiB.
constexpr int IO_BYTES = 256 * 1024;
/// Of one subscription, while its handler is busy: results of some frames.
constexpr int MOST_PENDING = 65536, MOST_PENDING_BYTES = 256 << 20;
constexpr auto LEAVE_PATIENCE = 2s;

class NatsTransport : public Transport {
public:
    NatsTransport(const BrokerOptions& options, const std::string& name) : nats_(natsLibrary()) {
        const std::vector<BrokerAddress> brokers = parseBrokers(options.url);
        checkBrokers(options, brokers);
        for (const BrokerAddress& broker : brokers) peer_ += (peer_.empty() ? "" : ",") + urlOf(broker);
        check(nats_.natsOptions_Create(&options_), "options");
        configure(options, brokers, name);
        natsStatus status = nats_.natsConnection_Connect(&connection_, options_);
        if (status == NATS_CONNECTION_AUTH_FAILED)
            refuse(" refuses who comes", "the broker's user and password or token in --pool-secret");
        if (status == NATS_SSL_ERROR)
            refuse(": its certificate is of nobody who is trusted here, or for another host",
                   "a broker whose certificate --pool-ca or the system's authorities signed for its address");
        if (status == NATS_PROTOCOL_ERROR && std::ranges::any_of(brokers, &BrokerAddress::tls))
            refuse(" wants another certificate of this machine, or none is given", "--pool-cert and --pool-key");
        if (status != NATS_OK) {
            log().warn("pool: no line to {} yet ({}); it is tried again", peer_, textOf(status));
            check(nats_.natsOptions_SetRetryOnFailedConnect(options_, true, onConnected, this), "retry");
            status = nats_.natsConnection_Connect(&connection_, options_);
            if (status != NATS_NOT_YET_CONNECTED) check(status, "connect");
        } else {
            log().info("pool: connected to {}", peer_);
        }
    }
    ~NatsTransport() override {
        ending_ = true;
        nats_.natsConnection_Close(connection_);
        if (closed_.get_future().wait_for(LEAVE_PATIENCE) != std::future_status::ready) log().debug("pool: the line hangs");
        nats_.natsConnection_Destroy(connection_);
        nats_.natsOptions_Destroy(options_);
    }

    bool publish(const std::string& subject, std::span<const uint8_t> bytes) override {
        if (bytes.size() > MOST_MESSAGE_BYTES || !connected()) return false;
        return nats_.natsConnection_Publish(connection_, subject.c_str(), bytes.data(), static_cast<int>(bytes.size())) ==
               NATS_OK;
    }
    std::shared_ptr<void> subscribe(const std::string& subject, Handler handler) override;
    bool publishFor(uint32_t number, const std::string& subject, std::span<const uint8_t> bytes) override {
        if (bytes.size() > MOST_MESSAGE_BYTES || !connected()) return false;
        const std::string reply = inbox_ + std::to_string(number);
        return nats_.natsConnection_PublishRequest(connection_, subject.c_str(), reply.c_str(), bytes.data(),
                                                   static_cast<int>(bytes.size())) == NATS_OK;
    }
    std::shared_ptr<void> whenNobody(std::function<void(uint32_t number)> handler) override;
    bool connected() const override { return nats_.natsConnection_Status(connection_) == NATS_CONN_STATUS_CONNECTED; }
    std::string peer() const override { return peer_; }

private:
    friend class NatsSubscription;

    std::string textOf(natsStatus status) const { return oneLine(nats_.natsStatus_GetText(status)); }
    void check(natsStatus status, const std::string& what) const {
        if (status != NATS_OK) throw std::runtime_error("NATS: " + what + ": " + textOf(status));
    }
    /// Nothing that time would mend.
    [[noreturn]] void refuse(const std::string& why, const std::string& allowed) {
        nats_.natsOptions_Destroy(options_);
        throw InputError("--pool", peer_ + why, allowed);
    }
    void configure(const BrokerOptions& options, const std::vector<BrokerAddress>& brokers, const std::string& name);

    static void onConnected(natsConnection*, void* self) {
        log().info("pool: connected to {}", static_cast<NatsTransport*>(self)->peer_);
    }
    static void onLost(natsConnection*, void* self) {
        const auto* transport = static_cast<NatsTransport*>(self);
        if (!transport->ending_) log().warn("pool: the line to {} is lost; it is tried again", transport->peer_);
    }
    static void onClosed(natsConnection*, void* self) {
        auto* transport = static_cast<NatsTransport*>(self);
        if (!transport->ending_)
            log().error("pool: the line to {} is closed for good: were its secrets changed?", transport->peer_);
        transport->closed_.set_value();
    }
    static void onError(natsConnection*, natsSubscription*, natsStatus status, void* self) {
        auto* transport = static_cast<NatsTransport*>(self);
        if (transport->errors_++ == 0) log().warn("pool: NATS: {}", transport->textOf(status));
    }

    const NatsLibrary& nats_;
    const std::string inbox_ = "_INBOX.heliograph" + peerText(newPeerId()) + ".";  // where a broker says that nobody listens
    std::string peer_;
    natsOptions* options_ = nullptr;
    natsConnection* connection_ = nullptr;
    std::atomic<bool> ending_{false};
    std::atomic<uint64_t> errors_{0};
    std::promise<void> closed_;
};

void NatsTransport::configure(const BrokerOptions& options, const std::vector<BrokerAddress>& brokers,
                              const std::string& name) {
    std::vector<std::string> urls;
    std::vector<const char*> pointers;
    urls.reserve(brokers.size());
    pointers.reserve(brokers.size());
    for (const BrokerAddress& broker : brokers) urls.push_back(urlOf(broker));
    for (const std::string& url : urls) pointers.push_back(url.c_str());
    check(nats_.natsOptions_SetServers(options_, pointers.data(), static_cast<int>(pointers.size())), "servers");
    check(nats_.natsOptions_SetName(options_, name.c_str()), "name");
    if (!options.secretFile.empty()) {
        const BrokerSecret secret = readBrokerSecret(options.secretFile);
        if (!secret.token.empty()) check(nats_.natsOptions_SetToken(options_, secret.token.c_str()), "token");
        else check(nats_.natsOptions_SetUserInfo(options_, secret.user.c_str(), secret.password.c_str()), "user");
    }
    if (std::ranges::any_of(brokers, &BrokerAddress::tls)) check(nats_.natsOptions_SetSecure(options_, true), "TLS");
    auto file = [&](natsStatus status, const std::string& option, const std::string& path) {
        if (status != NATS_OK) throw InputError(option, path + " cannot be used (" + textOf(status) + ")", "a PEM file");
    };
    if (!options.caFile.empty())
        file(nats_.natsOptions_LoadCATrustedCertificates(options_, options.caFile.c_str()), "--pool-ca", options.caFile);
    if (!options.certificate.empty())
        file(nats_.natsOptions_LoadCertificatesChain(options_, options.certificate.c_str(), options.key.c_str()), "--pool-cert",
             options.certificate);
    check(nats_.natsOptions_SetSendAsap(options_, true), "send at once");
    check(nats_.natsOptions_SetTimeout(options_, CONNECT_TIMEOUT), "timeout");
    check(nats_.natsOptions_SetIOBufSize(options_, IO_BYTES), "buffer");
    check(nats_.natsOptions_SetWriteDeadline(options_, WRITE_DEADLINE), "write deadline");
    check(nats_.natsOptions_SetPingInterval(options_, PING_EVERY), "ping interval");
    check(nats_.natsOptions_SetMaxPingsOut(options_, MOST_PINGS_OUT), "pings");
    check(nats_.natsOptions_SetMaxReconnect(options_, -1), "reconnects");
    check(nats_.natsOptions_SetReconnectWait(options_, RECONNECT_WAIT), "reconnect wait");
    check(nats_.natsOptions_SetReconnectJitter(options_, JITTER, JITTER), "jitter");
    check(nats_.natsOptions_SetReconnectBufSize(options_, RECONNECT_BYTES), "reconnect buffer");
    check(nats_.natsOptions_SetDisconnectedCB(options_, onLost, this), "callback");
    check(nats_.natsOptions_SetReconnectedCB(options_, onConnected, this), "callback");
    check(nats_.natsOptions_SetClosedCB(options_, onClosed, this), "callback");
    check(nats_.natsOptions_SetErrorHandler(options_, onError, this), "callback");
}

/// Ends when its last call has.
class NatsSubscription {
public:
    /// Of a message; its subject, and whether it says that nobody listens.
    using Handler = std::function<void(std::span<const uint8_t> bytes, std::string_view subject, bool isNobody)>;

    NatsSubscription(NatsTransport& transport, const std::string& subject, Handler handler)
        : nats_(transport.nats_), state_(std::make_shared<State>(transport.nats_, std::move(handler))) {
        transport.check(
            nats_.natsConnection_Subscribe(&subscription_, transport.connection_, subject.c_str(), onMessage, state_.get()),
            "subscribe");
        nats_.natsSubscription_SetPendingLimits(subscription_, MOST_PENDING, MOST_PENDING_BYTES);
        nats_.natsSubscription_SetOnCompleteCB(subscription_, onComplete, state_.get());
    }
    ~NatsSubscription() {
        nats_.natsSubscription_Unsubscribe(subscription_);
        if (state_->complete.get_future().wait_for(LEAVE_PATIENCE) != std::future_status::ready)
            static_cast<void>(std::make_unique<std::shared_ptr<State>>(state_).release());  // a call hangs: what it uses stays
        nats_.natsSubscription_Destroy(subscription_);
    }
    NatsSubscription(const NatsSubscription&) = delete;

private:
    struct State {
        State(const NatsLibrary& library, Handler handler) : nats(library), handle(std::move(handler)) {}
        const NatsLibrary& nats;
        const Handler handle;
        std::promise<void> complete;
    };

    static void onMessage(natsConnection*, natsSubscription*, natsMsg* message, void* state) {
        const auto* self = static_cast<const State*>(state);
        self->handle({reinterpret_cast<const uint8_t*>(self->nats.natsMsg_GetData(message)),
                      static_cast<size_t>(self->nats.natsMsg_GetDataLength(message))},
                     self->nats.natsMsg_GetSubject(message), self->nats.natsMsg_IsNoResponders(message));
        self->nats.natsMsg_Destroy(message);
    }
    static void onComplete(void* state) { static_cast<State*>(state)->complete.set_value(); }

    const NatsLibrary& nats_;
    const std::shared_ptr<State> state_;
    natsSubscription* subscription_ = nullptr;
};

std::shared_ptr<void> NatsTransport::subscribe(const std::string& subject, Handler handler) {
    return std::make_shared<NatsSubscription>(*this, subject, [handler = std::move(handler)](auto bytes, auto, bool isNobody) {
        if (!isNobody) handler(bytes);
    });
}

std::shared_ptr<void> NatsTransport::whenNobody(std::function<void(uint32_t number)> handler) {
    return std::make_shared<NatsSubscription>(
        *this, inbox_ + "*",
        [handler = std::move(handler), prefix = inbox_.size()](auto, std::string_view subject, bool isNobody) {
            uint32_t number = 0;
            if (isNobody && subject.size() > prefix)
                std::from_chars(subject.data() + prefix, subject.data() + subject.size(), number);
            if (number > 0) handler(number);
        });
}

}  // namespace

std::shared_ptr<Transport> makeNatsTransport(const BrokerOptions& options, const std::string& name) {
    return std::make_shared<NatsTransport>(options, name);
}

}  // namespace heliograph

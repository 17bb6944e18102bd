// TLS of the server. A browser that is offered HTTP/2 opens the WebSocket inside it, where libwebsockets 4.1.6 reads past
// its buffer: only HTTP/1.1 may be agreed on.

#include "server/net/socket_server.h"

#include "server/base/error.h"
#include "tests/support/until.h"
#include "tests/support/web_client.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

namespace fs = std::filesystem;

/// A certificate for localhost that signs itself, and its key, in a folder that goes away.
struct Certificate {
    fs::path folder;
    std::string certificateFile, keyFile;

    Certificate() {
        std::string pattern = (fs::temp_directory_path() / "heliograph-XXXXXX").string();
        folder = mkdtemp(pattern.data());
        certificateFile = (folder / "cert.pem").string();
        keyFile = (folder / "key.pem").string();
        EVP_PKEY* key = EVP_EC_gen("P-256");
        X509* x509 = X509_new();
        X509_set_version(x509, 2);
        ASN1_INTEGER_set(X509_get_serialNumber(x509), 1);
        X509_gmtime_adj(X509_getm_notBefore(x509), -60);
        X509_gmtime_adj(X509_getm_notAfter(x509), 3600);
        X509_set_pubkey(x509, key);
        X509_NAME* name = X509_get_subject_name(x509);
        X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, reinterpret_cast<const unsigned char*>("localhost"), -1, -1, 0);
        X509_set_issuer_name(x509, name);
        X509_sign(x509, key, EVP_sha256());
        FILE* file = std::fopen(certificateFile.c_str(), "w");
        PEM_write_X509(file, x509);
        std::fclose(file);
        file = std::fopen(keyFile.c_str(), "w");
        PEM_write_PrivateKey(file, key, nullptr, nullptr, 0, nullptr, nullptr);
        std::fclose(file);
        X509_free(x509);
        EVP_PKEY_free(key);
    }
    ~Certificate() { fs::remove_all(folder); }
};

/// Sends a frame of 300,000 bytes to whoever connects.
class Sender : public SocketHandler {
public:
    struct Peer : ViewerPeer {
        void receive(std::string_view) override {}
        void written(FrameKind, double, double) override {}
    };
    std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket> socket, bool) override {
        OutgoingPicture picture;
        picture.bytes.assign(SOCKET_HEADROOM + 300'000, 'p');
        picture.encoded = std::chrono::steady_clock::now();
        socket->sendPicture(std::move(picture));
        return std::make_shared<Peer>();
    }
    void closed(std::shared_ptr<ViewerPeer>, std::optional<CloseCode>) override {}
    void refused(unsigned, const std::string&) override {}
    std::string metricsText() override { return {}; }
    Readiness readiness() override { return {true, "{}"}; }
    bool ending() override { return false; }
    void turned() override {}
};

SocketOptions options(const Certificate& certificate) {
    SocketOptions o;
    o.listen = {parseListenAddress("127.0.0.1:0")};
    o.certificateFile = certificate.certificateFile;
    o.keyFile = certificate.keyFile;
    return o;
}

/// A client as a browser is one: it offers HTTP/2 first.
struct TlsClient {
    SSL_CTX* context = SSL_CTX_new(TLS_client_method());
    SSL* ssl = nullptr;
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);

    TlsClient(int port, int highestVersion = TLS1_3_VERSION, const char* cipher = "") {
        if (*cipher) SSL_CTX_set_cipher_list(context, cipher);
        SSL_CTX_set_max_proto_version(context, highestVersion);
        const unsigned char offer[] = {2, 'h', '2', 8, 'h', 't', 't', 'p', '/', '1', '.', '1'};
        SSL_CTX_set_alpn_protos(context, offer, sizeof offer);
        timeval patience{20, 0};
        setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(static_cast<uint16_t>(port));
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        ssl = SSL_new(context);
        SSL_set_fd(ssl, fd);
    }
    ~TlsClient() {
        SSL_free(ssl);
        SSL_CTX_free(context);
        ::close(fd);
    }
    bool shakeHands() { return SSL_connect(ssl) == 1; }
    std::string agreed() const {
        const unsigned char* name = nullptr;
        unsigned length = 0;
        SSL_get0_alpn_selected(ssl, &name, &length);
        return std::string(reinterpret_cast<const char*>(name), length);
    }
    void send(const std::string& bytes) { SSL_write(ssl, bytes.data(), static_cast<int>(bytes.size())); }
    /// Reads until there are so many bytes or the connection ends.
    std::string read(size_t wanted) {
        std::string all;
        char bytes[16384];
        while (all.size() < wanted) {
            int count = SSL_read(ssl, bytes, sizeof bytes);
            if (count <= 0) break;
            all.append(bytes, static_cast<size_t>(count));
        }
        return all;
    }
};

TEST(Tls, IsNotSpokenOverAUnixSocket) {
    Certificate certificate;
    SocketOptions both = options(certificate);
    const std::string path = certificate.certificateFile + ".sock";
    both.listen.push_back(parseListenAddress("unix:" + path));
    Sender handler;
    SocketServer server(both, handler);
    server.start();
    test::WebClient local(path);
    EXPECT_EQ(local.get("/healthz").body, "ok\n");
    TlsClient client(server.port());
    ASSERT_TRUE(client.shakeHands());
    client.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_TRUE(client.read(12).starts_with("HTTP/1.1 200"));
    EXPECT_EQ(local.get("/healthz").body, "ok\n");
}

TEST(Tls, AgreesOnHttp11AndCarriesLargeFrames) {
    Certificate certificate;
    Sender sender;
    SocketServer server(options(certificate), sender);
    server.start();
    EXPECT_TRUE(server.url().starts_with("https://"));
    TlsClient client(server.port());
    ASSERT_TRUE(client.shakeHands());
    EXPECT_EQ(client.agreed(), "http/1.1");
    client.send(
        "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: heliograph.v1\r\n\r\n");
    std::string all = client.read(300'100);
    EXPECT_TRUE(all.starts_with("HTTP/1.1 101"));
    EXPECT_EQ(std::count(all.begin(), all.end(), 'p') > 299'000, true) << all.size();
}

TEST(Tls, OldVersionsAreRefused) {
    Certificate certificate;
    Sender sender;
    SocketServer server(options(certificate), sender);
    server.start();
    EXPECT_FALSE(TlsClient(server.port(), TLS1_1_VERSION).shakeHands());
    EXPECT_TRUE(TlsClient(server.port(), TLS1_2_VERSION).shakeHands());
}

TEST(Tls, AKeyOfAnotherCertificateIsSaid) {
    Certificate one, other;
    SocketOptions mixed = options(one);
    mixed.keyFile = other.keyFile;
    Sender sender;
    EXPECT_THROW(SocketServer(mixed, sender), InputError);
}

/// The DER bytes of the certificate that the server shows.
std::string shownBy(int port) {
    TlsClient client(port);
    EXPECT_TRUE(client.shakeHands());
    X509* certificate = SSL_get1_peer_certificate(client.ssl);
    unsigned char* bytes = nullptr;
    const int size = i2d_X509(certificate, &bytes);
    std::string text(reinterpret_cast<char*>(bytes), static_cast<size_t>(size));
    OPENSSL_free(bytes);
    X509_free(certificate);
    return text;
}

TEST(Tls, ReloadShowsTheRenewedCertificate) {
    Certificate first, second;
    Sender sender;
    SocketServer server(options(first), sender);
    server.start();
    const std::string before = shownBy(server.port());
    SocketAccess mixed = options(first);
    mixed.keyFile = second.keyFile;
    EXPECT_THROW(server.reload(mixed), InputError);
    EXPECT_THROW(server.reload(SocketAccess()), InputError) << "TLS does not end";
    EXPECT_EQ(shownBy(server.port()), before);
    server.reload(options(second));
    std::string after = before;
    for (int i = 0; i < 1000 && after == before; i++) after = shownBy(server.port());
    EXPECT_NE(after, before);
}

/// Sends back what comes.
class Echo : public Sender {
public:
    struct Peer : ViewerPeer {
        explicit Peer(std::shared_ptr<ViewerSocket> s) : socket(std::move(s)) {}
        void receive(std::string_view text) override { socket->sendText(std::string(text)); }
        void written(FrameKind, double, double) override {}
        std::shared_ptr<ViewerSocket> socket;
    };
    std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket> socket, bool) override {
        return std::make_shared<Peer>(std::move(socket));
    }
    void closed(std::shared_ptr<ViewerPeer>, std::optional<CloseCode> code) override {
        lastCode = code ? static_cast<int>(*code) : 0;
    }
    std::atomic<int> lastCode{-1};
};

const std::string UPGRADE =
    "GET /ws HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: heliograph.v1\r\n\r\n";

TEST(Tls, RecordsAreNotChargedAsMessages) {
    for (int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
        Certificate certificate;
        Echo echo;
        SocketServer server(options(certificate), echo);
        server.start();
        TlsClient client(server.port(), version);
        ASSERT_TRUE(client.shakeHands());
        client.send(UPGRADE);
        ASSERT_TRUE(client.read(12).starts_with("HTTP/1.1 101"));
        // 1,200 small messages and pongs, each byte of the first hundred in a record of its own, and three large ones.
        for (int i = 0; i < 1200; i++) {
            const std::string frame = test::maskedFrame(1, R"({"type":"ack","frameId":123456})");
            if (i < 100) client.send(frame.substr(0, 6)), client.send(frame.substr(6));
            else client.send(frame);
            if (i % 20 == 0) client.send(test::maskedFrame(10, ""));
        }
        for (int i = 0; i < 3; i++) {
            const std::string frame = test::maskedFrame(1, std::string(60'000, 'x'));
            for (size_t at = 0; at < frame.size(); at += 1400) client.send(frame.substr(at, 1400));
        }
        client.send(test::maskedFrame(1, "the end"));
        std::string tail;
        while (!tail.ends_with("the end") && echo.lastCode == -1) {
            const std::string more = client.read(1);
            if (more.empty()) break;
            tail = (tail + more).substr(tail.size() > 100'000 ? 50'000 : 0);
        }
        EXPECT_TRUE(tail.ends_with("the end")) << version << " closed with " << echo.lastCode;
        std::this_thread::sleep_for(std::chrono::milliseconds(600));  // two looks of the server
        EXPECT_EQ(echo.lastCode, -1) << version;
    }
}

TEST(Tls, FramesWithoutAMaskAreRefused) {
    // Each cipher takes other room in a record.
    for (const char* cipher : {"ECDHE-ECDSA-AES128-GCM-SHA256", "ECDHE-ECDSA-CHACHA20-POLY1305", ""}) {
        Certificate certificate;
        Echo echo;
        SocketServer server(options(certificate), echo);
        server.start();
        TlsClient client(server.port(), *cipher ? TLS1_2_VERSION : TLS1_3_VERSION, cipher);
        ASSERT_TRUE(client.shakeHands()) << cipher;
        client.send(UPGRADE);
        ASSERT_TRUE(client.read(12).starts_with("HTTP/1.1 101"));
        for (int i = 0; i < 50; i++) client.send(test::maskedFrame(1, "masked"));
        std::this_thread::sleep_for(std::chrono::milliseconds(600));  // two looks of the server
        EXPECT_EQ(echo.lastCode, -1) << cipher;
        for (int i = 0; i < 3; i++) client.send(std::string("\x81\x08unmasked", 10));
        EXPECT_TRUE(test::until([&] { return echo.lastCode == 1002; })) << cipher << " " << echo.lastCode;
    }
}

TEST(Tls, PingsCountAsMessages) {
    Certificate certificate;
    Echo echo;
    SocketServer server(options(certificate), echo);
    server.start();
    TlsClient client(server.port());
    ASSERT_TRUE(client.shakeHands());
    client.send(UPGRADE);
    ASSERT_TRUE(client.read(12).starts_with("HTTP/1.1 101"));
    std::string pings;
    for (int i = 0; i < 40'000; i++) pings += test::maskedFrame(9, "");
    client.send(pings);
    EXPECT_TRUE(test::until([&] { return echo.lastCode == 1008; })) << echo.lastCode;
}

TEST(Tls, WhoNeverShakesHandsGivesWay) {
    Certificate certificate;
    Sender sender;
    SocketOptions small = options(certificate);
    small.maxViewers = 2;
    small.spareConnections = small.spareConnectionsPerAddress = 6;
    SocketServer server(small, sender);
    server.start();
    std::vector<std::unique_ptr<test::WebClient>> silent;
    for (int i = 0; i < 60; i++) {
        silent.push_back(std::make_unique<test::WebClient>(server.port()));
        if (i % 2) silent.back()->send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");  // no TLS
    }
    TlsClient client(server.port());
    EXPECT_TRUE(client.shakeHands());
}

}  // namespace
}  // namespace heliograph::TEST_FILE

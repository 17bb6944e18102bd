#include "server/net/port.h"

#include "server/base/ports.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace heliograph {

std::string bindProblem(const ListenAddress& listen) {
    const bool six = listen.host.find(':') != std::string::npos;
    sockaddr_storage address{};
    socklen_t size = 0;
    if (six) {
        auto* a = reinterpret_cast<sockaddr_in6*>(&address);
        a->sin6_family = AF_INET6;
        a->sin6_port = htons(static_cast<uint16_t>(listen.port));
        size = sizeof *a;
        if (inet_pton(AF_INET6, listen.host.c_str(), &a->sin6_addr) != 1) return "no IPv6 address";
    } else {
        auto* a = reinterpret_cast<sockaddr_in*>(&address);
        a->sin_family = AF_INET;
        a->sin_port = htons(static_cast<uint16_t>(listen.port));
        size = sizeof *a;
        if (inet_pton(AF_INET, listen.host.c_str(), &a->sin_addr) != 1) return "no IPv4 address";
    }
    int fd = socket(six ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return std::generic_category().message(errno);
    int on = 1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    bool bound = bind(fd, reinterpret_cast<sockaddr*>(&address), size) == 0;
    std::string problem = bound ? "" : bindFailure(errno, listen.port);
    ::close(fd);
    return problem;
}

bool useCertificate(ssl_ctx_st* context, const std::string& certificateFile, const std::string& keyFile) {
    // A key with a passphrase must not ask for it on the terminal.
    SSL_CTX_set_default_passwd_cb(context, [](char*, int, int, void*) { return 0; });
    const bool good = SSL_CTX_use_certificate_chain_file(context, certificateFile.c_str()) == 1 &&
                      SSL_CTX_use_PrivateKey_file(context, keyFile.c_str(), SSL_FILETYPE_PEM) == 1 &&
                      SSL_CTX_check_private_key(context) == 1;
    ERR_clear_error();
    return good;
}

}  // namespace heliograph

#include "server/net/web/tls.h"

#include "server/base/error.h"
#include "server/net/token.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <cstring>
#include <ctime>
#include <fstream>

namespace heliograph {

namespace {

constexpr int WARN_DAYS = 14;  // before a certificate ends

/// OpenSSL's reason for its last failure.
std::string reason() {
    const unsigned long code = ERR_peek_last_error();
    const char* text = code ? ERR_reason_error_string(code) : nullptr;
    ERR_clear_error();
    return text ? text : "unknown reason";
}

/// Asked for by OpenSSL when a key is encrypted; nobody is there to answer.
int noPassword(char*, int, int, void* asked) {
    *static_cast<bool*>(asked) = true;
    return -1;
}

int agreeOnHttp11(SSL*, const unsigned char** out, unsigned char* length, const unsigned char* in, unsigned inLength, void*) {
    static const unsigned char ours[] = "\x08http/1.1";
    unsigned char* chosen = nullptr;
    if (SSL_select_next_proto(&chosen, length, ours, sizeof ours - 1, in, inLength) != OPENSSL_NPN_NEGOTIATED)
        return SSL_TLSEXT_ERR_NOACK;
    *out = chosen;
    return SSL_TLSEXT_ERR_OK;
}

std::string dateOf(const ASN1_TIME* time) {
    std::tm utc{};
    char text[32] = "";
    if (ASN1_TIME_to_tm(time, &utc) == 1) std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &utc);
    return text;
}

void warnOfDates(const std::string& file, const X509* certificate, std::vector<std::string>& warnings) {
    std::time_t now = std::time(nullptr), soon = now + WARN_DAYS * 24 * 3600;
    const ASN1_TIME *begin = X509_get0_notBefore(certificate), *end = X509_get0_notAfter(certificate);
    if (X509_cmp_time(begin, &now) > 0) warnings.push_back(file + ": the certificate is not valid before " + dateOf(begin));
    if (X509_cmp_time(end, &now) < 0) warnings.push_back(file + ": the certificate has expired on " + dateOf(end));
    else if (X509_cmp_time(end, &soon) < 0) warnings.push_back(file + ": the certificate expires on " + dateOf(end));
}

void useKey(SSL_CTX* context, const std::string& certificateFile, const std::string& keyFile) {
    bool encrypted = false;
    SSL_CTX_set_default_passwd_cb(context, noPassword);
    SSL_CTX_set_default_passwd_cb_userdata(context, &encrypted);
    const bool loaded = SSL_CTX_use_PrivateKey_file(context, keyFile.c_str(), SSL_FILETYPE_PEM) == 1;
    SSL_CTX_set_default_passwd_cb_userdata(context, nullptr);
    SSL_CTX_set_default_passwd_cb(context, nullptr);
    if (encrypted) {
        ERR_clear_error();
        throw InputError(keyFile, "the key is encrypted, and nobody is there to say its password",
                         "a key without one, as from `openssl pkey -in KEY -out PLAIN`, that only the server's user can read");
    }
    if (!loaded)
        throw InputError(keyFile, "cannot be used as key with " + certificateFile + " (" + reason() + ")", "its PEM key");
    if (SSL_CTX_check_private_key(context) != 1)
        throw InputError(keyFile, "is not the key of " + certificateFile + " (" + reason() + ")", "its PEM key");
}

}  // namespace

TlsContext loadTls(const std::string& certificateFile, const std::string& keyFile, std::vector<std::string>& warnings) {
    for (const std::string& file : {certificateFile, keyFile}) {
        if (!std::ifstream(file)) throw InputError(file, std::string("cannot be read: ") + std::strerror(errno), "a PEM file");
    }
    TlsContext context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
    if (!context) throw InputError(certificateFile, "TLS cannot be set up (" + reason() + ")");
    SSL_CTX_set_min_proto_version(context.get(), TLS1_2_VERSION);
    SSL_CTX_set_options(context.get(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE);
    SSL_CTX_set_mode(context.get(),
                     SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER | SSL_MODE_RELEASE_BUFFERS);
    SSL_CTX_set_alpn_select_cb(context.get(), agreeOnHttp11, nullptr);
    ERR_clear_error();
    if (SSL_CTX_use_certificate_chain_file(context.get(), certificateFile.c_str()) != 1)
        throw InputError(certificateFile, "cannot be used as certificate (" + reason() + ")", "a PEM certificate");
    useKey(context.get(), certificateFile, keyFile);
    warnOfDates(certificateFile, SSL_CTX_get0_certificate(context.get()), warnings);
    if (std::string warning = readableByAll(keyFile); !warning.empty()) warnings.push_back(warning);
    return context;
}

}  // namespace heliograph

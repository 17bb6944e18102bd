#include "server/net/certificate.h"

#include <openssl/err.h>
#include <openssl/ssl.h>

namespace heliograph {

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

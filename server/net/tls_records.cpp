#include "server/net/tls_records.h"

#include <openssl/ssl.h>

#include <algorithm>
#include <memory>
#include <string_view>

namespace heliograph {

namespace {

struct Count {
    uint64_t bytes = 0;
    uint64_t inRecord = 0;  // of the record that was begun last
};

/// The connection owns its count.
int slot() {
    static const int index =
        SSL_get_ex_new_index(0, nullptr, nullptr, nullptr,
                             [](void*, void* data, CRYPTO_EX_DATA*, int, long, void*) { delete static_cast<Count*>(data); });
    return index;
}

/// Bytes that a record has at least beside its data: nonce, tag, and with TLS 1.3 the kind of what is inside.
uint64_t overhead(const SSL* ssl) {
    const SSL_CIPHER* cipher = SSL_get_current_cipher(ssl);
    const std::string_view name = cipher ? SSL_CIPHER_get_name(cipher) : "";
    const bool shortTag = name.ends_with("CCM8") || name.ends_with("CCM_8");
    if (SSL_version(ssl) >= TLS1_3_VERSION) return shortTag ? 9 : 17;
    return name.find("GCM") != name.npos ? 24 : 16;
}

void onMessage(int writing, int, int kind, const void* data, size_t length, SSL* ssl, void* argument) {
    constexpr size_t HEADER = 5;
    auto& count = *static_cast<Count*>(argument);
    const auto* bytes = static_cast<const uint8_t*>(data);
    if (writing) return;
    if (kind == SSL3_RT_HEADER && length == HEADER) {
        const uint64_t size = static_cast<uint64_t>(bytes[3]) << 8 | bytes[4];
        count.inRecord = size - std::min(size, overhead(ssl));
        if (SSL_version(ssl) < TLS1_3_VERSION && bytes[0] == SSL3_RT_APPLICATION_DATA) count.bytes += count.inRecord;
    }
    // TLS 1.3 calls every record application data and says inside what it is.
    if (kind == SSL3_RT_INNER_CONTENT_TYPE && length == 1 && bytes[0] == SSL3_RT_APPLICATION_DATA)
        count.bytes += count.inRecord;
}

}  // namespace

void countRecords(SSL* ssl) {
    auto count = std::make_unique<Count>();
    if (!SSL_set_ex_data(ssl, slot(), count.get())) return;
    SSL_set_msg_callback(ssl, onMessage);
    SSL_set_msg_callback_arg(ssl, count.release());
}

std::optional<uint64_t> recordBytes(const SSL* ssl) {
    const auto* count = static_cast<const Count*>(SSL_get_ex_data(ssl, slot()));
    return count ? std::optional(count->bytes) : std::nullopt;
}

}  // namespace heliograph

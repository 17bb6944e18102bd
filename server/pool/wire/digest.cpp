#include "server/pool/wire/digest.h"

#include <openssl/evp.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <vector>

namespace heliograph {

namespace {

class Hasher {
public:
    Hasher() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
        if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) fail();
    }
    void add(const void* data, size_t size) {
        if (EVP_DigestUpdate(context_.get(), data, size) != 1) fail();
    }
    Digest end() {
        Digest digest{};
        if (EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr) != 1) fail();
        return digest;
    }

private:
    [[noreturn]] static void fail() { throw std::runtime_error("SHA-256: OpenSSL refuses it"); }
    std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

Digest digestOf(std::span<const uint8_t> bytes) {
    Hasher hasher;
    hasher.add(bytes.data(), bytes.size());
    return hasher.end();
}

Digest buildDigest() {
    std::ifstream program("/proc/self/exe", std::ios::binary);
    std::vector<char> part(1u << 18);
    Hasher hasher;
    while (program.read(part.data(), static_cast<std::streamsize>(part.size())) || program.gcount() > 0)
        hasher.add(part.data(), static_cast<size_t>(program.gcount()));
    if (!program.eof()) throw std::runtime_error("/proc/self/exe: cannot be read, so this build cannot be told from others");
    return hasher.end();
}

std::string hexOf(const Digest& digest, size_t bytes) {
    static constexpr char DIGITS[] = "0123456789abcdef";
    std::string text;
    for (size_t i = 0; i < std::min(bytes, digest.size()); i++) {
        text += DIGITS[digest[i] >> 4];
        text += DIGITS[digest[i] & 15];
    }
    return text;
}

}  // namespace heliograph

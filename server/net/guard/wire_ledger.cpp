#include "server/net/guard/wire_ledger.h"

namespace heliograph {

namespace {

/// Bytes of the header of a masked frame.
constexpr uint64_t headerBytes(uint64_t payload) { return payload < 126 ? 6 : payload < 65536 ? 8 : 14; }

// What may have been read and not delivered yet: the library's buffer, over TLS a record and what is left of one.
constexpr double HELD_PLAIN = 16384 + 16, HELD_TLS = 3 * 16384;
// Records of TLS around a frame, header and payload in one each (some ciphers pad up to 60 bytes), more for a long one.
constexpr double RECORDS = 120.0, RECORD_SHARE = 1.0 / 8.0;

}  // namespace

void WireLedger::delivered(size_t piece, size_t left) {
    const uint64_t header = inside_ ? 0 : headerBytes(piece + left);
    inside_ = left > 0;
    least_ += piece + header;
    allowed_ += static_cast<double>(piece + header);
    if (wire_ == Wire::tls) allowed_ += (header > 0 ? RECORDS : 0.0) + RECORD_SHARE * static_cast<double>(piece);
}

double WireLedger::unaccounted(uint64_t consumed) {
    excess_ = std::max(0.0, excess_ + static_cast<double>(consumed - seen_) - allowed_);
    seen_ = consumed;
    allowed_ = 0.0;
    const double held = wire_ == Wire::plain ? HELD_PLAIN : HELD_TLS;
    const double charged = std::max(0.0, excess_ - held);
    excess_ -= charged;
    return charged / static_cast<double>(LEAST_FRAME);
}

}  // namespace heliograph

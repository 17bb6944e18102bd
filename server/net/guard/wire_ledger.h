#pragma once
// Accounts for the bytes of a WebSocket that the library reads: it answers pings and takes empty frames and pongs without a
// word, and takes frames without a mask. What came over the wire beyond what was delivered is charged as messages; what came
// short of the headers that masked frames have tells of frames without a mask (RFC 6455, 5.1). Pure.

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace heliograph {

class WireLedger {
public:
    enum class Wire { plain, tls };

    /// `consumed`: bytes read from the socket when the WebSocket opened.
    WireLedger(Wire wire, uint64_t consumed) : wire_(wire), opened_(consumed), seen_(consumed) {}

    /// Nothing was delivered yet.
    bool untouched() const { return least_ == 0; }
    /// A piece of a frame was delivered; `left` bytes of the frame are to come.
    void delivered(size_t piece, size_t left);

    /// More was delivered than can have come in masked frames since the WebSocket opened. `consumed`: bytes read from the
    /// socket by now. Never over TLS, where records hide how long frames are.
    bool unmasked(uint64_t consumed) const { return wire_ == Wire::plain && consumed - opened_ < least_; }
    /// The same over TLS. `data`: bytes that came in its records since the WebSocket opened.
    bool unmaskedInRecords(uint64_t data) const { return wire_ == Wire::tls && data < least_; }

    /// Messages that the bytes make up which came since the last call and were not delivered, at LEAST_FRAME bytes each.
    double unaccounted(uint64_t consumed);

    static constexpr uint64_t LEAST_FRAME = 6;  // bytes of a masked frame without payload

private:
    const Wire wire_;
    const uint64_t opened_;
    uint64_t least_ = 0;    // bytes that what was delivered took at least, in masked frames
    bool inside_ = false;   // a frame of which more is to come
    uint64_t seen_;         // bytes, at the last look
    double allowed_ = 0.0;  // bytes for what was delivered since
    double excess_ = 0.0;   // bytes beyond that, never less than none: what was allowed too much is no credit
};

}  // namespace heliograph

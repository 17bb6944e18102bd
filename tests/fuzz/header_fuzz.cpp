// The header before a picture: what is read is what was written.

#include "server/net/protocol.h"
#include "tests/fuzz/fuzz.h"

#include <algorithm>

using namespace heliograph;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return fuzz::refusing([&] {
        const FrameHeader header = readFrameHeader({data, size});
        std::array<uint8_t, FRAME_HEADER_BYTES> bytes{};
        writeFrameHeader(header, bytes);
        std::vector<uint8_t> message(bytes.begin(), bytes.end());
        message.resize(FRAME_HEADER_BYTES + std::min<size_t>(header.payloadBytes, 65536));
        if (header.payloadBytes <= 65536 && header.relativeError == header.relativeError &&
            !(readFrameHeader(message) == header))
            __builtin_trap();
    });
}

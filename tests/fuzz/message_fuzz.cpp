// What a viewer may say.

#include "server/net/protocol.h"
#include "tests/fuzz/fuzz.h"

using namespace heliograph;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    return fuzz::refusing([&] { parseViewerMessage({reinterpret_cast<const char*>(data), size}); });
}

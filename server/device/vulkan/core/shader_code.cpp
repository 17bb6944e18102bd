#include "server/device/vulkan/core/shader_code.h"

#include <stdexcept>

#include <zlib.h>

namespace heliograph::shaders {

std::vector<uint32_t> unpacked(std::span<const unsigned char> packed, size_t bytes) {
    std::vector<uint32_t> words(bytes / sizeof(uint32_t));
    z_stream stream{};
    stream.next_in = const_cast<unsigned char*>(packed.data());  // zlib reads it alone
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = reinterpret_cast<unsigned char*>(words.data());
    stream.avail_out = static_cast<uInt>(words.size() * sizeof(uint32_t));
    constexpr int GZIP = 15 + 16;  // largest window, gzip's header
    const bool begun = inflateInit2(&stream, GZIP) == Z_OK;
    const bool whole = begun && inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.total_out == bytes;
    if (begun) inflateEnd(&stream);
    if (!whole) throw std::runtime_error("the program's shaders are damaged");
    return words;
}

}  // namespace heliograph::shaders

#include "server/device/vulkan/core/shader_code.h"

#include <stdexcept>

#include <zlib.h>

namespace heliograph::shaders {

std::vector<uint32_t> unpacked(std::span<const unsigned char> packed, size_t bytes) {
    std::vector<unsigned char> planes(bytes);
    z_stream stream{};
    stream.next_in = const_cast<unsigned char*>(packed.data());  // zlib reads it alone
    stream.avail_in = static_cast<uInt>(packed.size());
    stream.next_out = planes.data();
    stream.avail_out = static_cast<uInt>(planes.size());
    constexpr int GZIP = 15 + 16;  // largest window, gzip's header
    const bool begun = inflateInit2(&stream, GZIP) == Z_OK;
    const bool whole = begun && inflate(&stream, Z_FINISH) == Z_STREAM_END && stream.total_out == bytes;
    if (begun) inflateEnd(&stream);
    if (!whole) throw std::runtime_error("the program's shaders are damaged");
    std::vector<uint32_t> words(bytes / sizeof(uint32_t));
    for (size_t i = 0; i < words.size(); i++) {
        for (size_t byte = 0; byte < sizeof(uint32_t); byte++)
            words[i] |= uint32_t(planes[byte * words.size() + i]) << (8 * byte);
    }
    return words;
}

}  // namespace heliograph::shaders

#include "server/encode/jpeg_stripes.h"

#include <stdexcept>

namespace heliograph {

namespace {

constexpr uint8_t MARK = 0xff, START_OF_FRAME = 0xc0, START_OF_SCAN = 0xda, END = 0xd9, RESTART = 0xd0, RESTART_INTERVAL = 0xdd;

/// Where things stand in a file.
struct Layout {
    size_t frame = 0;  // marker of the frame's header
    size_t scan = 0;   // marker of the scan's header
    size_t data = 0;   // what the scan codes, up to the end marker
    size_t end = 0;
};

Layout layoutOf(std::span<const uint8_t> file) {
    Layout at;
    size_t place = 2;
    while (place + 4 <= file.size() && file[place] == MARK) {
        const uint8_t kind = file[place + 1];
        const size_t length = 2 + (static_cast<size_t>(file[place + 2]) << 8 | file[place + 3]);
        if (place + length + 2 > file.size()) break;
        if (kind == START_OF_FRAME) at.frame = place;
        if (kind == START_OF_SCAN) {
            at.scan = place;
            at.data = place + length;
            at.end = file.size() - 2;
            break;
        }
        place += length;
    }
    if (at.frame == 0 || at.data == 0 || at.data > at.end || file[at.end] != MARK || file[at.end + 1] != END) {
        throw std::runtime_error("jpeg: a stripe is no baseline file");
    }
    return at;
}

}  // namespace

void joinStripes(std::span<const std::span<const uint8_t>> stripes, uint32_t height, uint32_t unitsPerStripe,
                 std::vector<uint8_t>& bytes) {
    for (size_t i = 0; i < stripes.size(); i++) {
        const std::span<const uint8_t> file = stripes[i];
        const Layout at = layoutOf(file);
        if (i == 0) {
            const size_t rows = bytes.size() + at.frame + 5;
            bytes.insert(bytes.end(), file.begin(), file.begin() + static_cast<ptrdiff_t>(at.scan));
            bytes[rows] = static_cast<uint8_t>(height >> 8);
            bytes[rows + 1] = static_cast<uint8_t>(height);
            if (stripes.size() > 1) {
                bytes.insert(bytes.end(), {MARK, RESTART_INTERVAL, 0, 4, static_cast<uint8_t>(unitsPerStripe >> 8),
                                           static_cast<uint8_t>(unitsPerStripe)});
            }
            bytes.insert(bytes.end(), file.begin() + static_cast<ptrdiff_t>(at.scan),
                         file.begin() + static_cast<ptrdiff_t>(at.data));
        } else {
            bytes.insert(bytes.end(), {MARK, static_cast<uint8_t>(RESTART + (i - 1) % 8)});
        }
        bytes.insert(bytes.end(), file.begin() + static_cast<ptrdiff_t>(at.data),
                     file.begin() + static_cast<ptrdiff_t>(at.end));
    }
    bytes.insert(bytes.end(), {MARK, END});
}

}  // namespace heliograph

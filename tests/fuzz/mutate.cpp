#include "tests/fuzz/mutate.h"

#include <algorithm>
#include <string_view>

namespace heliograph::fuzz {

namespace {

using Offset = Bytes::difference_type;

constexpr std::string_view NUMBERS[] = {
    "0",    "-1",    "1",          "2",          "3",          "7",          "48",
    "255",  "65536", "2147483647", "2147483648", "4294967295", "4294967296", "18446744073709551616",
    "1e19", "1e38",  "1e39",       "1e308",      "1e400",      "1e-19",      "1e-45",
    "-0.0", "0.5",   "null"};
constexpr uint32_t WORDS[] = {0u, 1u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu, 0x7F800000u, 0x7FC00000u, 0x00010000u};

bool ofNumber(uint8_t byte) { return (byte >= '0' && byte <= '9') || byte == '-' || byte == '.'; }

uint32_t below(test::Random& random, size_t limit) { return random.below(static_cast<uint32_t>(std::max<size_t>(limit, 1))); }

/// A place in it, its end among them.
Offset place(const Bytes& bytes, test::Random& random) { return static_cast<Offset>(below(random, bytes.size() + 1)); }

/// The whole number at or after a random place becomes another one.
void replaceNumber(Bytes& bytes, test::Random& random) {
    auto begin = std::find_if(bytes.begin() + place(bytes, random), bytes.end(), ofNumber);
    while (begin != bytes.begin() && begin != bytes.end() && ofNumber(*(begin - 1))) --begin;
    const auto end = std::find_if_not(begin, bytes.end(), ofNumber);
    const std::string_view number = NUMBERS[below(random, std::size(NUMBERS))];
    bytes.insert(bytes.erase(begin, end), number.begin(), number.end());
}

void replaceWord(Bytes& bytes, test::Random& random) {
    const uint32_t word = WORDS[below(random, std::size(WORDS))];
    size_t at = static_cast<size_t>(place(bytes, random)) / 4 * 4;
    for (uint32_t i = 0; i < 4 && at < bytes.size(); i++, at++) bytes[at] = static_cast<uint8_t>(word >> 8 * i);
}

void erase(Bytes& bytes, test::Random& random) {
    const Offset at = place(bytes, random);
    const auto count = std::min<Offset>(static_cast<Offset>(1 + random.below(64)), static_cast<Offset>(bytes.size()) - at);
    bytes.erase(bytes.begin() + at, bytes.begin() + at + count);
}

/// A piece of another input, or of itself, put in at a random place.
void insert(Bytes& bytes, const Bytes& other, test::Random& random) {
    const Offset from = place(other, random);
    const auto count = std::min<Offset>(static_cast<Offset>(1 + random.below(200)), static_cast<Offset>(other.size()) - from);
    const Bytes piece(other.begin() + from, other.begin() + from + count);
    bytes.insert(bytes.begin() + place(bytes, random), piece.begin(), piece.end());
}

void change(Bytes& bytes, std::span<const Bytes> others, test::Random& random) {
    const uint32_t kind = random.below(8);
    if (bytes.empty() || kind == 0) return insert(bytes, others[below(random, others.size())], random);
    switch (kind) {
        case 1: bytes[below(random, bytes.size())] ^= static_cast<uint8_t>(1u << random.below(8)); break;
        case 2: bytes[below(random, bytes.size())] = static_cast<uint8_t>(random.below(256)); break;
        case 3: erase(bytes, random); break;
        case 4: insert(bytes, Bytes(bytes), random); break;
        case 5: replaceWord(bytes, random); break;
        case 6:
            if (random.below(8) == 0) bytes.resize(below(random, bytes.size()));
            break;
        default: replaceNumber(bytes, random);
    }
}

}  // namespace

Bytes mutated(const Bytes& from, std::span<const Bytes> others, test::Random& random, size_t mostBytes) {
    Bytes bytes = from;
    // Half of all stay texts of the same shape, so that they get beyond the parser.
    const bool numbersAlone = random.below(2) == 0;
    for (uint32_t changes = 1u << random.below(numbersAlone ? 2 : 4); changes > 0; changes--) {
        if (numbersAlone) replaceNumber(bytes, random);
        else change(bytes, others, random);
    }
    if (bytes.size() > mostBytes) bytes.resize(mostBytes);
    return bytes;
}

}  // namespace heliograph::fuzz

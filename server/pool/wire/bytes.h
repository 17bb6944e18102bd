#pragma once
// Messages as bytes, little-endian, and a reader that never looks past their end.

#include "server/base/error.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace heliograph {

static_assert(std::endian::native == std::endian::little, "messages are little-endian and are copied as they lie in memory");

/// What a stranger sent is no message of the pool, or not one of this version.
class PoolMessageError : public InputError {
public:
    explicit PoolMessageError(const std::string& what) : InputError("pool message", what) {}
};

class ByteWriter {
public:
    template <typename T>
    void put(T value) {
        static_assert(std::is_arithmetic_v<T>);
        raw(&value, sizeof value);
    }
    /// At most 65,535 bytes; what is longer is cut.
    void text(std::string_view text) {
        const auto length = static_cast<uint16_t>(std::min<size_t>(text.size(), UINT16_MAX));
        put(length);
        raw(text.data(), length);
    }
    void raw(const void* data, size_t size) {
        if (size == 0) return;
        const size_t at = bytes_.size();
        bytes_.resize(at + size);
        std::memcpy(bytes_.data() + at, data, size);
    }
    /// Puts a value where one was put before.
    template <typename T>
    void set(size_t at, T value) {
        std::memcpy(bytes_.data() + at, &value, sizeof value);
    }
    size_t size() const { return bytes_.size(); }
    std::vector<uint8_t> take() { return std::move(bytes_); }
    std::span<const uint8_t> bytes() const { return bytes_; }

private:
    std::vector<uint8_t> bytes_;
};

/// Throws PoolMessageError instead of reading past the end.
class ByteReader {
public:
    explicit ByteReader(std::span<const uint8_t> bytes) : rest_(bytes) {}

    template <typename T>
    T get() {
        static_assert(std::is_arithmetic_v<T>);
        T value;
        std::memcpy(&value, raw(sizeof value).data(), sizeof value);
        return value;
    }
    std::string text() {
        const std::span<const uint8_t> bytes = raw(get<uint16_t>());
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    std::span<const uint8_t> raw(size_t size) {
        if (size > rest_.size()) throw PoolMessageError("ends too soon");
        const std::span<const uint8_t> bytes = rest_.first(size);
        rest_ = rest_.subspan(size);
        return bytes;
    }
    /// A number of things that take at least `least` bytes each: no more than can follow.
    uint32_t count(size_t least) {
        const auto number = get<uint32_t>();
        if (number > rest_.size() / least) throw PoolMessageError("ends before all that it announces");
        return number;
    }
    size_t left() const { return rest_.size(); }
    void end() const {
        if (!rest_.empty()) throw PoolMessageError("goes on after its end");
    }

private:
    std::span<const uint8_t> rest_;
};

}  // namespace heliograph

#pragma once
// Memory that tile programs use again for every tile. Part of them: no shared inline code.

#include "server/device/embree/tile_job.h"

#include <cstdlib>
#include <cstring>

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

/// Grows, never shrinks, does not initialise; 64-byte aligned.
template <typename T>
struct Buffer {
    T* data = nullptr;
    uint32_t capacity = 0;
    Buffer() = default;
    Buffer(const Buffer&) = delete;
    Buffer& operator=(const Buffer&) = delete;
    ~Buffer() { std::free(data); }
    /// Makes room for `count` elements, keeping the first `kept`.
    void reserve(uint32_t count, uint32_t kept = 0) {
        if (count <= capacity) return;
        size_t bytes = (size_t(count) * sizeof(T) + 63) / 64 * 64;
        T* grown = static_cast<T*>(std::aligned_alloc(64, bytes));
        if (!grown) throwNoMemory();
        if (kept) std::memcpy(static_cast<void*>(grown), data, size_t(kept) * sizeof(T));
        std::free(data);
        data = grown;
        capacity = count;
    }
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

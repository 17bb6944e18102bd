#pragma once
// The order in which rays that have scattered are traced: by where they go, so that one finds the nodes of the tree in the
// caches that the one before has passed. After Garanzha & Loop, "Fast Ray Sorting and Breadth-First Packet Traversal for GPU
// Ray Tracing" (2010). Part of the tile programs: no shared inline code.

#include "server/device/embree/tile_buffer.h"

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

/// A counting sort over the cells of a cube of directions, eight along an axis.
class RayOrder {
public:
    static constexpr uint32_t MOST = 0xffffu;  // rays

    /// Numbers of the first `count` rays (at most MOST) of `packets`, cell by cell, in a cell as they come. Valid until the next
    /// call.
    const uint16_t* sort(const RTCRay16* packets, uint32_t count) {
        key_.reserve(count);
        order_.reserve(count);
        std::memset(start_, 0, sizeof start_);
        for (uint32_t i = 0; i < count; i++) {
            const RTCRay16& rays = packets[i / PACKET];
            const uint32_t at = i % PACKET;
            key_.data[i] =
                static_cast<uint16_t>(cellOf(rays.dir_x[at]) | cellOf(rays.dir_y[at]) << 3 | cellOf(rays.dir_z[at]) << 6);
            start_[key_.data[i] + 1]++;
        }
        for (uint32_t i = 0; i < CELLS; i++) start_[i + 1] = static_cast<uint16_t>(start_[i + 1] + start_[i]);
        for (uint32_t i = 0; i < count; i++) order_.data[start_[key_.data[i]]++] = static_cast<uint16_t>(i);
        return order_.data;
    }

private:
    static constexpr uint32_t CELLS = 512;

    /// Of eight along [-1, 1]; what is no number is in the first.
    static uint32_t cellOf(float x) {
        const float inside = x > -1.0f ? (x < 1.0f ? x : 1.0f) : -1.0f;
        return static_cast<uint32_t>((inside + 1.0f) * 3.999f);
    }

    Buffer<uint16_t> key_;
    Buffer<uint16_t> order_;
    uint16_t start_[CELLS + 1];
};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

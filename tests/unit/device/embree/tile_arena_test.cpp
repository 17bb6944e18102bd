#define HELIOGRAPH_KERNEL_NAMESPACE lanes_under_test

#include "server/device/embree/tile_arena.h"

#include <gtest/gtest.h>

#include <array>
#include <new>

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool ALLOCATOR_ABORTS = true;
#else
constexpr bool ALLOCATOR_ABORTS = false;
#endif

// More than any machine can address: one frame is lost by it, and what the arena held is still there.
TEST(TileArena, WithoutMemoryABufferThrowsAndKeepsWhatItHolds) {
    if (ALLOCATOR_ABORTS) GTEST_SKIP() << "the sanitizer's allocator ends the process instead";
    using Megabyte = std::array<char, 1u << 20>;
    Buffer<Megabyte> buffer;
    buffer.reserve(1);
    buffer.data[0][7] = 'x';
    EXPECT_THROW(buffer.reserve(0xFFFFFFFFu, 1), std::bad_alloc);
    EXPECT_EQ(buffer.capacity, 1u);
    EXPECT_EQ(buffer.data[0][7], 'x');
    buffer.reserve(2, 1);
    EXPECT_EQ(buffer.capacity, 2u);
    EXPECT_EQ(buffer.data[0][7], 'x');
}

}  // namespace
}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

#pragma once
// The C++ side of shaders/vulkan/bindings.glsl and fetch_table.glsl: the same constants and structs, their layouts asserted.

#include "server/film/tile.h"

namespace heliograph {

#define UINT_CONSTANT(name, value) constexpr uint name = value;
#include "shaders/vulkan/bindings.glsl"

static_assert(sizeof(TraceTile) == 32 && offsetof(TraceTile, size) == 8 && offsetof(TraceTile, firstSample) == 16 &&
              offsetof(TraceTile, firstPixel) == 28);
#define RAY_KIND(number, NAME, name, word) static_assert(number == uint(RayKind::name));
#include "shaders/kernel/ray_table.glsl"
static_assert(COUNT_NONFINITE == uint(RayKind::count) && COUNT_MEDIA_OVERFLOW < COUNTS_PER_TILE);

/// Offsets of a row's components, bytes.
namespace fetch_component {
constexpr size_t x = 0, y = 4, z = 8, w = 12;
}
#define FETCH_ROW(T, field, row) \
    static_assert(offsetof(T, field) == 16 * row && sizeof(T::field) == 16 && sizeof(T) == 16 * ROWS_##T);
#define FETCH_PAIR(T, field, row) static_assert(offsetof(T, field) == 16 * row && sizeof(T) == 16 * ROWS_##T);
#define FETCH_FLOAT(T, field, row, component) \
    static_assert(offsetof(T, field) == 16 * row + fetch_component::component && sizeof(T) == 16 * ROWS_##T);
#define FETCH_UINT(T, field, row, component) FETCH_FLOAT(T, field, row, component)
#include "shaders/vulkan/fetch_table.glsl"
#undef FETCH_ROW
#undef FETCH_PAIR
#undef FETCH_FLOAT
#undef FETCH_UINT
#undef UINT_CONSTANT

// Rows of fetchLight.
static_assert(sizeof(Light) == 5 * 16 && offsetof(Light, range) == 12 && offsetof(Light, direction) == 16 &&
              offsetof(Light, cosInner) == 28 && offsetof(Light, intensity) == 32 && offsetof(Light, cosOuter) == 44 &&
              offsetof(Light, type) == 48 && offsetof(Light, falloff) == 52 && offsetof(Light, radius) == 56 &&
              offsetof(Light, edge) == 64 && offsetof(Light, aspect) == 76);

}  // namespace heliograph

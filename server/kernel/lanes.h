#pragma once
// Numbers with one value per SIMD lane, so that the kernel's source also compiles to code that shades 16, 8 or 4 points
// at once (AVX-512, AVX2, SSE4). Built on the compiler's vector extensions; each lane computes exactly what the scalar
// kernel computes. A Bool has no conversion to bool: a branch on lanes must say ANY(), and choose values by SELECT().

#include "server/kernel/kernel_types.h"

#include <immintrin.h>

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

#define HELIOGRAPH_INLINE inline __attribute__((always_inline))

#if defined(__AVX512F__)
constexpr int LANES = 16;
#elif defined(__AVX2__)
constexpr int LANES = 8;
#else
constexpr int LANES = 4;
#endif

typedef float VectorFloat __attribute__((vector_size(4 * LANES)));
typedef int32_t VectorInt __attribute__((vector_size(4 * LANES)));
typedef uint32_t VectorUint __attribute__((vector_size(4 * LANES)));

struct Int;
struct Uint;

struct Bool {
    VectorInt v;  // -1 or 0
    HELIOGRAPH_INLINE Bool() = default;
    HELIOGRAPH_INLINE Bool(VectorInt value) : v(value) {}
    HELIOGRAPH_INLINE Bool(bool value) : v(VectorInt{} - (value ? 1 : 0)) {}
    friend HELIOGRAPH_INLINE Bool operator&&(Bool a, Bool b) { return Bool(a.v & b.v); }
    friend HELIOGRAPH_INLINE Bool operator||(Bool a, Bool b) { return Bool(a.v | b.v); }
    friend HELIOGRAPH_INLINE Bool operator!(Bool a) { return Bool(~a.v); }
    friend HELIOGRAPH_INLINE Bool operator==(Bool a, Bool b) { return Bool(~(a.v ^ b.v)); }
};

struct Float {
    VectorFloat v;
    HELIOGRAPH_INLINE Float() = default;
    HELIOGRAPH_INLINE Float(VectorFloat value) : v(value) {}
    HELIOGRAPH_INLINE Float(float value) : v(VectorFloat{} + value) {}
    HELIOGRAPH_INLINE explicit Float(Int value);
    HELIOGRAPH_INLINE explicit Float(Uint value);
    friend HELIOGRAPH_INLINE Float operator+(Float a, Float b) { return Float(a.v + b.v); }
    friend HELIOGRAPH_INLINE Float operator-(Float a, Float b) { return Float(a.v - b.v); }
    friend HELIOGRAPH_INLINE Float operator*(Float a, Float b) { return Float(a.v * b.v); }
    friend HELIOGRAPH_INLINE Float operator/(Float a, Float b) { return Float(a.v / b.v); }
    friend HELIOGRAPH_INLINE Float operator-(Float a) { return Float(-a.v); }
    friend HELIOGRAPH_INLINE Bool operator<(Float a, Float b) { return Bool(a.v < b.v); }
    friend HELIOGRAPH_INLINE Bool operator>(Float a, Float b) { return Bool(a.v > b.v); }
    friend HELIOGRAPH_INLINE Bool operator<=(Float a, Float b) { return Bool(a.v <= b.v); }
    friend HELIOGRAPH_INLINE Bool operator>=(Float a, Float b) { return Bool(a.v >= b.v); }
    friend HELIOGRAPH_INLINE Bool operator==(Float a, Float b) { return Bool(a.v == b.v); }
    friend HELIOGRAPH_INLINE Bool operator!=(Float a, Float b) { return Bool(a.v != b.v); }
};

struct Int {
    VectorInt v;
    HELIOGRAPH_INLINE Int() = default;
    HELIOGRAPH_INLINE Int(VectorInt value) : v(value) {}
    HELIOGRAPH_INLINE Int(int32_t value) : v(VectorInt{} + value) {}
    HELIOGRAPH_INLINE explicit Int(Float value) : v(__builtin_convertvector(value.v, VectorInt)) {}
    HELIOGRAPH_INLINE explicit Int(Uint value);
    friend HELIOGRAPH_INLINE Int operator+(Int a, Int b) { return Int(a.v + b.v); }
    friend HELIOGRAPH_INLINE Int operator-(Int a, Int b) { return Int(a.v - b.v); }
    friend HELIOGRAPH_INLINE Int operator-(Int a) { return Int(-a.v); }
    friend HELIOGRAPH_INLINE Int operator*(Int a, Int b) { return Int(a.v * b.v); }
    friend HELIOGRAPH_INLINE Int operator&(Int a, Int b) { return Int(a.v & b.v); }
    friend HELIOGRAPH_INLINE Int operator|(Int a, Int b) { return Int(a.v | b.v); }
    friend HELIOGRAPH_INLINE Int operator<<(Int a, int n) { return Int(a.v << n); }
    friend HELIOGRAPH_INLINE Int operator>>(Int a, int n) { return Int(a.v >> n); }
    friend HELIOGRAPH_INLINE Bool operator<(Int a, Int b) { return Bool(a.v < b.v); }
    friend HELIOGRAPH_INLINE Bool operator>(Int a, Int b) { return Bool(a.v > b.v); }
    friend HELIOGRAPH_INLINE Bool operator>=(Int a, Int b) { return Bool(a.v >= b.v); }
    friend HELIOGRAPH_INLINE Bool operator==(Int a, Int b) { return Bool(a.v == b.v); }
    friend HELIOGRAPH_INLINE Bool operator!=(Int a, Int b) { return Bool(a.v != b.v); }
};

struct Uint {
    VectorUint v;
    HELIOGRAPH_INLINE Uint() = default;
    HELIOGRAPH_INLINE Uint(VectorUint value) : v(value) {}
    HELIOGRAPH_INLINE Uint(uint32_t value) : v(VectorUint{} + value) {}
    HELIOGRAPH_INLINE explicit Uint(Int value) : v((VectorUint)value.v) {}
    HELIOGRAPH_INLINE explicit Uint(Float value) : v((VectorUint) __builtin_convertvector(value.v, VectorInt)) {}
    friend HELIOGRAPH_INLINE Uint operator+(Uint a, Uint b) { return Uint(a.v + b.v); }
    friend HELIOGRAPH_INLINE Uint operator-(Uint a, Uint b) { return Uint(a.v - b.v); }
    friend HELIOGRAPH_INLINE Uint operator*(Uint a, Uint b) { return Uint(a.v * b.v); }
    friend HELIOGRAPH_INLINE Uint operator&(Uint a, Uint b) { return Uint(a.v & b.v); }
    friend HELIOGRAPH_INLINE Uint operator|(Uint a, Uint b) { return Uint(a.v | b.v); }
    friend HELIOGRAPH_INLINE Uint operator^(Uint a, Uint b) { return Uint(a.v ^ b.v); }
    friend HELIOGRAPH_INLINE Uint operator<<(Uint a, int n) { return Uint(a.v << n); }
    friend HELIOGRAPH_INLINE Uint operator>>(Uint a, int n) { return Uint(a.v >> n); }
    friend HELIOGRAPH_INLINE Bool operator==(Uint a, Uint b) { return Bool(a.v == b.v); }
    friend HELIOGRAPH_INLINE Bool operator!=(Uint a, Uint b) { return Bool(a.v != b.v); }
    friend HELIOGRAPH_INLINE Bool operator<(Uint a, Uint b) { return Bool(a.v < b.v); }
    friend HELIOGRAPH_INLINE Bool operator>(Uint a, Uint b) { return Bool(a.v > b.v); }
    friend HELIOGRAPH_INLINE Bool operator<=(Uint a, Uint b) { return Bool(a.v <= b.v); }
    friend HELIOGRAPH_INLINE Bool operator>=(Uint a, Uint b) { return Bool(a.v >= b.v); }
};

Float::Float(Int value) : v(__builtin_convertvector(value.v, VectorFloat)) {}
Float::Float(Uint value) : v(__builtin_convertvector((VectorInt)value.v, VectorFloat)) {}  // values below 2^31 only
Int::Int(Uint value) : v((VectorInt)value.v) {}

HELIOGRAPH_INLINE Float select(Bool c, Float a, Float b) { return Float(c.v ? a.v : b.v); }
HELIOGRAPH_INLINE Int select(Bool c, Int a, Int b) { return Int(c.v ? a.v : b.v); }
HELIOGRAPH_INLINE Uint select(Bool c, Uint a, Uint b) { return Uint(c.v ? a.v : b.v); }
HELIOGRAPH_INLINE Float select(Bool c, float a, float b) { return select(c, Float(a), Float(b)); }
HELIOGRAPH_INLINE Bool select(Bool c, Bool a, Bool b) { return Bool((c.v & a.v) | (~c.v & b.v)); }

HELIOGRAPH_INLINE uint32_t laneBits(Bool c) {
#if defined(__AVX512F__)
    return _mm512_test_epi32_mask((__m512i)c.v, (__m512i)c.v);
#elif defined(__AVX2__)
    return static_cast<uint32_t>(_mm256_movemask_ps((__m256)c.v));
#else
    return static_cast<uint32_t>(_mm_movemask_ps((__m128)c.v));
#endif
}
HELIOGRAPH_INLINE bool anyLane(Bool c) { return laneBits(c) != 0; }
HELIOGRAPH_INLINE bool anyLane(bool c) { return c; }

HELIOGRAPH_INLINE Float sqrt(Float x) {
#if defined(__AVX512F__)
    return Float((VectorFloat)_mm512_sqrt_ps((__m512)x.v));
#elif defined(__AVX2__)
    return Float((VectorFloat)_mm256_sqrt_ps((__m256)x.v));
#else
    return Float((VectorFloat)_mm_sqrt_ps((__m128)x.v));
#endif
}
HELIOGRAPH_INLINE Float floor(Float x) {
#if defined(__AVX512F__)
    return Float((VectorFloat)_mm512_roundscale_ps((__m512)x.v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC));
#elif defined(__AVX2__)
    return Float((VectorFloat)_mm256_floor_ps((__m256)x.v));
#else
    return Float((VectorFloat)_mm_floor_ps((__m128)x.v));
#endif
}
HELIOGRAPH_INLINE Int floatBitsToInt(Float x) { return Int((VectorInt)x.v); }
HELIOGRAPH_INLINE Float intBitsToFloat(Int x) { return Float((VectorFloat)x.v); }
HELIOGRAPH_INLINE Float abs(Float x) { return Float((VectorFloat)((VectorInt)x.v & 0x7fffffff)); }
// The same choice as glm's for scalars: the first operand unless the second is really smaller (larger).
HELIOGRAPH_INLINE Float min(Float a, Float b) { return Float(b.v < a.v ? b.v : a.v); }
HELIOGRAPH_INLINE Float max(Float a, Float b) { return Float(a.v < b.v ? b.v : a.v); }
HELIOGRAPH_INLINE float min(float a, float b) { return b < a ? b : a; }
HELIOGRAPH_INLINE float max(float a, float b) { return a < b ? b : a; }
HELIOGRAPH_INLINE Int min(Int a, Int b) { return Int(b.v < a.v ? b.v : a.v); }
HELIOGRAPH_INLINE Int max(Int a, Int b) { return Int(a.v < b.v ? b.v : a.v); }
HELIOGRAPH_INLINE Uint min(Uint a, Uint b) { return Uint(b.v < a.v ? b.v : a.v); }

struct Vec2 {
    Float x, y;
    HELIOGRAPH_INLINE Vec2() = default;
    HELIOGRAPH_INLINE Vec2(Float a, Float b) : x(a), y(b) {}
    HELIOGRAPH_INLINE Vec2(glm::vec2 a) : x(a.x), y(a.y) {}
    friend HELIOGRAPH_INLINE Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
};

struct Vec3 {
    Float x, y, z;
    HELIOGRAPH_INLINE Vec3() = default;
    HELIOGRAPH_INLINE Vec3(Float a, Float b, Float c) : x(a), y(b), z(c) {}
    HELIOGRAPH_INLINE Vec3(glm::vec3 a) : x(a.x), y(a.y), z(a.z) {}
    friend HELIOGRAPH_INLINE Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend HELIOGRAPH_INLINE Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend HELIOGRAPH_INLINE Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
    friend HELIOGRAPH_INLINE Vec3 operator*(Vec3 a, Float b) { return {a.x * b, a.y * b, a.z * b}; }
    friend HELIOGRAPH_INLINE Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
};

struct Vec4 {
    Float x, y, z, w;
    HELIOGRAPH_INLINE Vec4() = default;
    HELIOGRAPH_INLINE Vec4(Float a, Float b, Float c, Float d) : x(a), y(b), z(c), w(d) {}
    HELIOGRAPH_INLINE Vec4(glm::vec4 a) : x(a.x), y(a.y), z(a.z), w(a.w) {}
    friend HELIOGRAPH_INLINE Vec4 operator+(Vec4 a, Vec4 b) { return {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w}; }
    friend HELIOGRAPH_INLINE Vec4 operator-(Vec4 a, Vec4 b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w}; }
    friend HELIOGRAPH_INLINE Vec4 operator*(Vec4 a, Vec4 b) { return {a.x * b.x, a.y * b.y, a.z * b.z, a.w * b.w}; }
    friend HELIOGRAPH_INLINE Vec4 operator*(Vec4 a, Float b) { return {a.x * b, a.y * b, a.z * b, a.w * b}; }
};

// What is the same for all lanes comes as GLM's vectors.
HELIOGRAPH_INLINE Vec3 operator*(glm::vec3 a, Float b) { return Vec3(a) * b; }
HELIOGRAPH_INLINE Vec4 operator*(glm::vec4 a, Float b) { return Vec4(a) * b; }

struct Uvec2 {
    Uint x, y;
    HELIOGRAPH_INLINE Uvec2() = default;
    HELIOGRAPH_INLINE Uvec2(Uint a, Uint b) : x(a), y(b) {}
    HELIOGRAPH_INLINE Uvec2(glm::uvec2 a) : x(a.x), y(a.y) {}
};

struct Uvec4 {
    Uint x, y, z, w;
};

// The sums in GLM's order.
HELIOGRAPH_INLINE Float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HELIOGRAPH_INLINE Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y}; }
HELIOGRAPH_INLINE Vec2 select(Bool c, Vec2 a, Vec2 b) { return {select(c, a.x, b.x), select(c, a.y, b.y)}; }
HELIOGRAPH_INLINE Vec3 select(Bool c, Vec3 a, Vec3 b) {
    return {select(c, a.x, b.x), select(c, a.y, b.y), select(c, a.z, b.z)};
}
HELIOGRAPH_INLINE Vec4 select(Bool c, Vec4 a, Vec4 b) {
    return {select(c, a.x, b.x), select(c, a.y, b.y), select(c, a.z, b.z), select(c, a.w, b.w)};
}

struct HitLanes {
    Uint instance, primitive;
};

struct RayLanes {
    Vec3 origin;
    Float tMax;
    Vec3 direction;
};

// ---- loads by lane ----

HELIOGRAPH_INLINE bool sameInAllLanes(Uint index) { return !anyLane(index != Uint(index.v[0])); }

// 32-bit words at base + index * stride bytes.
HELIOGRAPH_INLINE VectorInt gatherWords(const void* base, Uint index, uint32_t stride) {
    VectorUint offset = index.v * (stride / 4);
#if defined(__AVX512F__)
    return (VectorInt)_mm512_i32gather_epi32((__m512i)offset, base, 4);
#elif defined(__AVX2__)
    return (VectorInt)_mm256_i32gather_epi32(static_cast<const int*>(base), (__m256i)offset, 4);
#else
    const int32_t* words = static_cast<const int32_t*>(base);
    return VectorInt{words[offset[0]], words[offset[1]], words[offset[2]], words[offset[3]]};
#endif
}

// Rows of four 32-bit words at base + index * stride bytes, transposed: 128-bit loads cost far less than four gathers.
HELIOGRAPH_INLINE void gatherRows(const void* base, Uint index, uint32_t stride, VectorFloat& x, VectorFloat& y, VectorFloat& z,
                                  VectorFloat& w) {
    const char* bytes = static_cast<const char*>(base);
    alignas(64) uint32_t at[LANES];  // through memory: taking lanes out of a register one by one is slower
    __builtin_memcpy(at, &index.v, sizeof at);
    auto row = [&](int lane) { return _mm_loadu_ps(reinterpret_cast<const float*>(bytes + size_t(at[lane]) * stride)); };
#if defined(__AVX512F__)
    auto rows = [&](int i) {
        __m512 r = _mm512_castps128_ps512(row(i));
        r = _mm512_insertf32x4(r, row(i + 4), 1);
        r = _mm512_insertf32x4(r, row(i + 8), 2);
        return _mm512_insertf32x4(r, row(i + 12), 3);
    };
    __m512 r0 = rows(0), r1 = rows(1), r2 = rows(2), r3 = rows(3);
    __m512 xy01 = _mm512_unpacklo_ps(r0, r1), xy23 = _mm512_unpacklo_ps(r2, r3);
    __m512 zw01 = _mm512_unpackhi_ps(r0, r1), zw23 = _mm512_unpackhi_ps(r2, r3);
    x = (VectorFloat)_mm512_shuffle_ps(xy01, xy23, 0x44);
    y = (VectorFloat)_mm512_shuffle_ps(xy01, xy23, 0xee);
    z = (VectorFloat)_mm512_shuffle_ps(zw01, zw23, 0x44);
    w = (VectorFloat)_mm512_shuffle_ps(zw01, zw23, 0xee);
#elif defined(__AVX2__)
    auto rows = [&](int i) { return _mm256_insertf128_ps(_mm256_castps128_ps256(row(i)), row(i + 4), 1); };
    __m256 r0 = rows(0), r1 = rows(1), r2 = rows(2), r3 = rows(3);
    __m256 xy01 = _mm256_unpacklo_ps(r0, r1), xy23 = _mm256_unpacklo_ps(r2, r3);
    __m256 zw01 = _mm256_unpackhi_ps(r0, r1), zw23 = _mm256_unpackhi_ps(r2, r3);
    x = (VectorFloat)_mm256_shuffle_ps(xy01, xy23, 0x44);
    y = (VectorFloat)_mm256_shuffle_ps(xy01, xy23, 0xee);
    z = (VectorFloat)_mm256_shuffle_ps(zw01, zw23, 0x44);
    w = (VectorFloat)_mm256_shuffle_ps(zw01, zw23, 0xee);
#else
    __m128 r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
    _MM_TRANSPOSE4_PS(r0, r1, r2, r3);
    x = (VectorFloat)r0;
    y = (VectorFloat)r1;
    z = (VectorFloat)r2;
    w = (VectorFloat)r3;
#endif
}
HELIOGRAPH_INLINE Vec4 gatherRow(const float* row, Uint index, uint32_t stride) {
    VectorFloat x, y, z, w;
    gatherRows(row, index, stride, x, y, z, w);
    return {Float(x), Float(y), Float(z), Float(w)};
}
HELIOGRAPH_INLINE Uvec4 gatherRow(const uint32_t* row, Uint index, uint32_t stride) {
    VectorFloat x, y, z, w;
    gatherRows(row, index, stride, x, y, z, w);
    return {Uint((VectorUint)x), Uint((VectorUint)y), Uint((VectorUint)z), Uint((VectorUint)w)};
}

// Four words from an index on; one load where it is the same for all lanes.
HELIOGRAPH_INLINE Uvec4 sharedRow(const uint32_t* words, Uint index) {
    if (!sameInAllLanes(index)) return gatherRow(words, index, 4);
    const uint32_t* row = words + index.v[0];
    return {Uint(row[0]), Uint(row[1]), Uint(row[2]), Uint(row[3])};
}

// One field of an array of structs, for each lane's index. Neighbouring points mostly share their materials and images:
// one load then serves all lanes.
HELIOGRAPH_INLINE Float gather(const float* field, Uint index, uint32_t stride) {
    if (sameInAllLanes(index)) return Float(field[size_t(index.v[0]) * (stride / 4)]);
    return Float((VectorFloat)gatherWords(field, index, stride));
}
HELIOGRAPH_INLINE Uint gather(const uint32_t* field, Uint index, uint32_t stride) {
    if (sameInAllLanes(index)) return Uint(field[size_t(index.v[0]) * (stride / 4)]);
    return Uint((VectorUint)gatherWords(field, index, stride));
}
HELIOGRAPH_INLINE Uvec2 gatherPair(const glm::uvec2* pairs, Uint index) {
    return {gather(&pairs->x, index, sizeof(glm::uvec2)), gather(&pairs->y, index, sizeof(glm::uvec2))};
}
HELIOGRAPH_INLINE Vec2 gather(const glm::vec2* field, Uint index, uint32_t stride) {
    return {gather(&field->x, index, stride), gather(&field->y, index, stride)};
}
HELIOGRAPH_INLINE Vec3 gather(const glm::vec3* field, Uint index, uint32_t stride) {
    return {gather(&field->x, index, stride), gather(&field->y, index, stride), gather(&field->z, index, stride)};
}
HELIOGRAPH_INLINE Vec4 gather(const glm::vec4* field, Uint index, uint32_t stride) {
    if (sameInAllLanes(index)) return Vec4(field[size_t(index.v[0]) * (stride / 16)]);
    return gatherRow(&field->x, index, stride);
}

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

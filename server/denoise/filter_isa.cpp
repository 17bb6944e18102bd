// The rows of filter_program.h, compiled once per instruction set: HELIOGRAPH_KERNEL_NAMESPACE names the build. Everything here
// lives in that namespace or is always inlined (tests/check_isa.sh looks).

#include "server/denoise/filter_program.h"
#include "server/kernel/lanes.h"

#include <cstring>

#define IN(T) const T&
#define OUT(T) T&
#define INOUT(T) T&
#define SELECT(condition, yes, no) select(condition, yes, no)
#define ANY(condition) anyLane(condition)
#define FLOAT_CONSTANT(name, value) static constexpr ScalarFloat name = value;
#define UINT_CONSTANT(name, value) static constexpr uint32_t name = value;
#define UNIFORM_UINT uint32_t

namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE {

namespace {

using ScalarFloat = float;

#define float Float
#define int Int
#define uint Uint
#define bool Bool
#define vec2 Vec2
#define vec3 Vec3
#define vec4 Vec4
#define uvec2 Uvec2

struct Filter {
#include "shaders/kernel/math.glsl"
#include "shaders/denoise/filter.glsl"
};

#undef float
#undef int
#undef uint
#undef bool
#undef vec2
#undef vec3
#undef vec4
#undef uvec2
using enum DenoisePlane;

static_assert(LANES <= DENOISE_MARGIN);
static_assert(Filter::DENOISE_ROUNDS == 5 && 1u << (Filter::DENOISE_ROUNDS - 1) == DENOISE_MARGIN);

struct Row {
    const DenoiseView& view;
    ptrdiff_t at;  // of the row's first pixel

    HELIOGRAPH_INLINE Row(const DenoiseView& v, uint32_t row) : view(v), at(static_cast<ptrdiff_t>(row * v.stride)) {}
    HELIOGRAPH_INLINE Float get(DenoisePlane plane, ptrdiff_t offset) const {
        Float value;
        std::memcpy(&value.v, view.planes[static_cast<size_t>(plane)] + at + offset, sizeof value.v);
        return value;
    }
    HELIOGRAPH_INLINE void put(DenoisePlane plane, uint32_t x, Float value) const {
        std::memcpy(view.planes[static_cast<size_t>(plane)] + at + x, &value.v, sizeof value.v);
    }
    HELIOGRAPH_INLINE Filter::GuidePixel guide(ptrdiff_t offset) const {
        Filter::GuidePixel g;
        g.normal = Vec3(get(normalX, offset), get(normalY, offset), get(normalZ, offset));
        g.nearness = get(nearness, offset);
        return g;
    }
};

void prepareRow(const DenoiseView& view, uint32_t row) {
    Filter filter;
    const Row r(view, row);
    for (uint32_t x = 0; x < view.size.x; x += LANES) {
        const Vec3 divisor = filter.divisorOf(Uint(r.get(albedoWord, x)));
        Float variance = r.get(varianceA, x);
        variance = filter.demodulatedVariance(variance, divisor);
        r.put(redA, x, filter.demodulated(r.get(redA, x), divisor.x));
        r.put(greenA, x, filter.demodulated(r.get(greenA, x), divisor.y));
        r.put(blueA, x, filter.demodulated(r.get(blueA, x), divisor.z));
        r.put(varianceA, x, variance);
        const Filter::GuidePixel guide = filter.guidePixel(Uint(r.get(normalWord, x)), r.get(nearness, x));
        r.put(normalX, x, guide.normal.x);
        r.put(normalY, x, guide.normal.y);
        r.put(normalZ, x, guide.normal.z);
    }
}

void estimateRow(const DenoiseView& view, uint32_t row) {
    Filter filter;
    const Row r(view, row);
    const auto stride = static_cast<ptrdiff_t>(view.stride);
    for (uint32_t x = 0; x < view.size.x; x += LANES) {
        const Filter::GuidePixel own = r.guide(x);
        const Float sx = filter.nearnessSlope(r.get(nearness, ptrdiff_t(x) - 1), own.nearness, r.get(nearness, x + 1));
        const Float sy =
            filter.nearnessSlope(r.get(nearness, ptrdiff_t(x) - stride), own.nearness, r.get(nearness, x + stride));
        r.put(slopeX, x, sx);
        r.put(slopeY, x, sy);
        const Float cut = filter.planeCut(own.nearness);
        Filter::Around around = filter.aroundNothing();
        for (int reach = 0; reach <= 2; reach++) {
            for (int dy = -reach; dy <= reach; dy += reach > 0 ? reach : 1) {
                for (int dx = -reach; dx <= reach; dx += reach > 0 ? reach : 1) {
                    if (reach > 0 && dx == 0 && dy == 0) continue;
                    const ptrdiff_t at = ptrdiff_t(x) + dx + dy * stride;
                    const Float expected = own.nearness + sx * float(dx) + sy * float(dy);
                    const Float like = filter.surfaceLikeness(own, r.guide(at), expected, cut);
                    const Vec3 light(r.get(redA, at), r.get(greenA, at), r.get(blueA, at));
                    filter.addAround(around, like, filter.luminance(light), r.get(varianceA, at));
                }
            }
        }
        r.put(varianceB, x, filter.varianceAround(around, filter.sharpShare(Uint(r.get(normalWord, x)))));
    }
}

template <bool TO_B>
HELIOGRAPH_INLINE void filterRowOf(const DenoiseView& view, uint32_t row, int step) {
    constexpr DenoisePlane RED = TO_B ? redA : redB, GREEN = TO_B ? greenA : greenB, BLUE = TO_B ? blueA : blueB;
    constexpr DenoisePlane VARIANCE = TO_B ? varianceB : varianceA;
    Filter filter;
    const Row r(view, row);
    const ptrdiff_t down = static_cast<ptrdiff_t>(view.stride) * step;
    for (uint32_t x = 0; x < view.size.x; x += LANES) {
        const Filter::GuidePixel own = r.guide(x);
        const Float sx = r.get(slopeX, x) * float(step), sy = r.get(slopeY, x) * float(step);
        const Float cut = filter.planeCut(own.nearness);
        const Vec3 light(r.get(RED, x), r.get(GREEN, x), r.get(BLUE, x));
        const Float variance = r.get(VARIANCE, x), brightness = filter.luminance(light);
        Filter::Gathered sum = filter.gatheredOwn(light, variance);
        for (int dy = -1; dy <= 1; dy++) {
            for (int dx = -1; dx <= 1; dx++) {
                if (dx == 0 && dy == 0) continue;
                const ptrdiff_t at = ptrdiff_t(x) + dx * step + dy * down;
                const Float expected = own.nearness + sx * float(dx) + sy * float(dy);
                const Float like = filter.surfaceLikeness(own, r.guide(at), expected, cut);
                const Vec3 other(r.get(RED, at), r.get(GREEN, at), r.get(BLUE, at));
                const float tap = dx == 0 || dy == 0 ? Filter::SIDE_WEIGHT : Filter::CORNER_WEIGHT;
                const Float otherVariance = r.get(VARIANCE, at);
                const Float alike = filter.lightLikeness(brightness, filter.luminance(other), variance + otherVariance);
                filter.addNeighbour(sum, like * alike * tap, other, otherVariance);
            }
        }
        const Vec3 mean = filter.gatheredLight(sum);
        r.put(TO_B ? redB : redA, x, mean.x);
        r.put(TO_B ? greenB : greenA, x, mean.y);
        r.put(TO_B ? blueB : blueA, x, mean.z);
        r.put(TO_B ? varianceA : varianceB, x, filter.gatheredVariance(sum));
    }
}

void filterRow(const DenoiseView& view, uint32_t row, uint32_t round) {
    if (round % 2 == 0) filterRowOf<true>(view, row, 1 << round);
    else filterRowOf<false>(view, row, 1 << round);
}

void finishRow(const DenoiseView& view, uint32_t row) {
    Filter filter;
    const Row r(view, row);
    for (uint32_t x = 0; x < view.size.x; x += LANES) {
        const Vec3 divisor = filter.divisorOf(Uint(r.get(albedoWord, x)));
        r.put(redA, x, r.get(redB, x) * divisor.x);
        r.put(greenA, x, r.get(greenB, x) * divisor.y);
        r.put(blueA, x, r.get(blueB, x) * divisor.z);
    }
}

}  // namespace

extern const DenoiseProgram DENOISE_PROGRAM;
const DenoiseProgram DENOISE_PROGRAM = {HELIOGRAPH_ISA_NAME, prepareRow, estimateRow, filterRow, finishRow};

}  // namespace heliograph::HELIOGRAPH_KERNEL_NAMESPACE

#include "server/kernel/kernel_undefine.inc"

#pragma once
// The filter of shaders/denoise/filter.glsl on processors, row by row, as plain data: it is compiled for several instruction sets
// and may share no inline code with the rest.

#include "server/kernel/kernel_types.h"

namespace heliograph {

/// Numbers of a pixel, one plane each. Light is that without the surfaces' colour; A and B take turns.
enum class DenoisePlane {
    redA,
    greenA,
    blueA,
    varianceA,  // of the luminance of the light; below 0 where one sample cannot tell
    redB,
    greenB,
    blueB,
    varianceB,
    normalX,
    normalY,
    normalZ,
    nearness,
    slopeX,  // of nearness, a pixel
    slopeY,
    albedoWord,  // as the guides have them (shaders/denoise/guides.glsl)
    normalWord,
    count
};

constexpr uint32_t DENOISE_PLANES = static_cast<uint32_t>(DenoisePlane::count);
/// Pixels that planes have around the picture, on each side: as far as the last round looks. Their nearness is -1, their light 0.
constexpr uint32_t DENOISE_MARGIN = 16;

struct DenoiseView {
    float* planes[DENOISE_PLANES];  // at the picture's first pixel
    size_t stride = 0;              // floats from row to row; there are DENOISE_MARGIN more behind the margin of each
    uvec2 size{0, 0};
};

/// What is done with one row of a view. Rows are independent: those of a step may run side by side, but each step needs all of
/// the one before.
struct DenoiseProgram {
    const char* instructionSet;
    /// Light in A, its variance, words and nearness are given: divides light by the surfaces' colour and unpacks the normals.
    void (*prepareRow)(const DenoiseView& view, uint32_t row);
    /// Slopes, and the variance around each pixel, from A into varianceB.
    void (*estimateRow)(const DenoiseView& view, uint32_t row);
    /// Round `round` of DENOISE_ROUNDS: even ones filter A into B with varianceB into varianceA, odd ones the other way.
    void (*filterRow)(const DenoiseView& view, uint32_t row, uint32_t round);
    /// B times the surfaces' colour, into A.
    void (*finishRow)(const DenoiseView& view, uint32_t row);
};

}  // namespace heliograph

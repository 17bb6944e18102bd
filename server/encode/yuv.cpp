#include "server/encode/yuv.h"

#include <algorithm>

namespace heliograph {

namespace {

// BT.709 (Kr 0.2126, Kb 0.0722) for limited range, in 1/65536. The colour rows sum to 0, so that grey stays grey.
constexpr int32_t Y_RED = 11966, Y_GREEN = 40254, Y_BLUE = 4064;
constexpr int32_t U_RED = -6596, U_GREEN = -22189, U_BLUE = 28785;
constexpr int32_t V_RED = 28785, V_GREEN = -26145, V_BLUE = -2640;
constexpr int32_t HALF = 1 << 15;

void lumaRow(const uint8_t* rgba, uint32_t width, uint8_t* y) {
    for (uint32_t x = 0; x < width; x++) {
        const int32_t r = rgba[4 * x], g = rgba[4 * x + 1], b = rgba[4 * x + 2];
        y[x] = static_cast<uint8_t>((Y_RED * r + Y_GREEN * g + Y_BLUE * b + (16 << 16) + HALF) >> 16);
    }
}

/// Of sums of four pixels.
uint8_t colour(int32_t r, int32_t g, int32_t b, int32_t red, int32_t green, int32_t blue) {
    return static_cast<uint8_t>((red * r + green * g + blue * b + (128 << 18) + (HALF << 2)) >> 18);
}

void colourRow(const uint8_t* upper, const uint8_t* lower, uint32_t width, uint8_t* u, uint8_t* v) {
    for (uint32_t x = 0; x < width / 2; x++) {
        const uint8_t* a = upper + 8 * x;
        const uint8_t* c = lower + 8 * x;
        const int32_t r = a[0] + a[4] + c[0] + c[4], g = a[1] + a[5] + c[1] + c[5], b = a[2] + a[6] + c[2] + c[6];
        u[x] = colour(r, g, b, U_RED, U_GREEN, U_BLUE);
        v[x] = colour(r, g, b, V_RED, V_GREEN, V_BLUE);
    }
    if (width % 2 == 0) return;
    const uint8_t* a = upper + 4 * (width - 1);
    const uint8_t* c = lower + 4 * (width - 1);
    const int32_t r = 2 * (a[0] + c[0]), g = 2 * (a[1] + c[1]), b = 2 * (a[2] + c[2]);
    u[width / 2] = colour(r, g, b, U_RED, U_GREEN, U_BLUE);
    v[width / 2] = colour(r, g, b, V_RED, V_GREEN, V_BLUE);
}

}  // namespace

void toYuv(const DisplayImage& image, YuvImage& yuv) {
    yuv.width = image.width;
    yuv.height = image.height;
    const size_t columns = yuv.colourWidth(), rows = yuv.colourHeight();
    yuv.y.resize(static_cast<size_t>(image.width) * image.height);
    yuv.u.resize(columns * rows);
    yuv.v.resize(columns * rows);
    const size_t rowBytes = size_t{4} * image.width;
    for (uint32_t row = 0; row < image.height; row += 2) {
        const uint8_t* upper = image.rgba.data() + row * rowBytes;
        const uint8_t* lower = row + 1 < image.height ? upper + rowBytes : upper;
        uint8_t* y = yuv.y.data() + static_cast<size_t>(row) * image.width;
        lumaRow(upper, image.width, y);
        if (lower != upper) lumaRow(lower, image.width, y + image.width);
        colourRow(upper, lower, image.width, &yuv.u[row / 2 * columns], &yuv.v[row / 2 * columns]);
    }
}

}  // namespace heliograph

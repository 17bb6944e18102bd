#include "server/scene/generate/noise.h"
#include "server/scene/generate/surfaces.h"

#include <algorithm>
#include <cmath>

namespace heliograph::generate {

namespace {

constexpr float TURN = 6.2831853f;

/// Linear transmittances of one window's glass.
struct Palette {
    vec3 ground, second, third, accent, pale;
};

constexpr Palette PALETTES[3] = {
    {{0.72f, 0.05f, 0.05f}, {0.10f, 0.16f, 0.62f}, {0.80f, 0.50f, 0.08f}, {0.08f, 0.42f, 0.16f}, {0.90f, 0.80f, 0.58f}},
    {{0.06f, 0.16f, 0.66f}, {0.10f, 0.36f, 0.62f}, {0.72f, 0.07f, 0.08f}, {0.80f, 0.56f, 0.12f}, {0.78f, 0.84f, 0.84f}},
    {{0.66f, 0.62f, 0.52f},
     {0.58f, 0.60f, 0.54f},
     {0.74f, 0.60f, 0.30f},
     {0.34f, 0.46f, 0.58f},
     {0.80f, 0.77f, 0.68f}}};

/// A point of the glass and how far away the next lead is (the scale is that of the pattern, not metres).
struct Piece {
    vec3 color{0.0f};
    float lead = 0.0f;
};

/// A medallion: a boss, a ring of eight petals, an outer ring. Polar coordinates about its middle; `number`: its place.
Piece medallion(const Palette& glass, float angle, float radius, int number) {
    const float turn = (angle / TURN + 0.5f) * 8.0f, within = fraction(turn);
    const int sector = int(std::floor(turn));
    const float ray = 6.0f * std::min(within, 1.0f - within) * radius * 0.8f;
    if (radius < 0.12f) return {glass.accent, 4.0f * (0.12f - radius)};
    if (radius < 0.27f) {
        const vec3 color = (sector + number) % 2 == 0 ? glass.third : glass.pale;
        return {color, std::min({ray, 4.0f * (radius - 0.12f), 4.0f * (0.27f - radius)})};
    }
    return {sector % 2 == 0 ? glass.second : glass.accent,
            std::min({ray, 4.0f * (radius - 0.27f), 4.0f * (0.36f - radius)})};
}

Piece pieceAt(const Palette& glass, vec2 uv, uint32_t seed) {
    // Two columns of six medallions, small pieces of the ground colour around them, a beaded border.
    const vec2 p(fraction(uv.x * 2.0f) - 0.5f, uv.y * 6.0f), local(p.x * 1.15f, fraction(p.y) - 0.5f);
    const float angle = std::atan2(local.y, local.x),
                radius = glm::length(local) * (1.0f + 0.10f * std::cos(4.0f * angle));
    const float border = 0.5f - std::abs(p.x);
    const Cell cell = cellNoise(vec2(uv.x * 12.0f, uv.y * 30.0f), 60, seed + 3, 0.8f);
    Piece piece;
    if (border < 0.07f) {
        const float bead = fraction(p.y * 5.0f);
        const vec3 color = int(std::floor(p.y * 5.0f)) % 2 == 0 ? glass.third : glass.pale;
        piece = {color, std::min(0.5f * std::min(bead, 1.0f - bead), 6.0f * (0.07f - border))};
    } else if (radius < 0.36f) {
        piece = medallion(glass, angle, radius, int(std::floor(p.y)) * 2 + (uv.x < 0.5f ? 0 : 1));
    } else {
        const vec3 color = glm::mix(glass.ground, glass.second, cell.id < 0.3f ? 0.9f : 0.25f * cell.id);
        piece = {color, std::min({0.5f * cell.border, 4.0f * (radius - 0.36f), 6.0f * (border - 0.07f)})};
    }
    const float streaks = fractalNoise(vec2(uv.x * 20.0f, uv.y * 48.0f), 4096, 3, seed);
    piece.color *= 0.80f + 0.35f * (streaks - 0.3f) + 0.2f * (cell.id - 0.5f);
    return piece;
}

uint8_t srgbByte(float linear) {
    const float l = std::clamp(linear, 0.0f, 1.0f);
    const float coded = l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1.0f / 2.4f) - 0.055f;
    return uint8_t(coded * 255.0f + 0.5f);
}

}  // namespace

ImageData paintStainedGlass(const std::string& name, uint32_t width, int palette, uint32_t seed) {
    const uint32_t height = 2 * width;
    ImageData image{.width = width, .height = height, .srgb = true, .name = name};
    image.rgba8.resize(size_t(width) * height * 4);
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) {
            const vec2 uv((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height));
            const Piece piece = pieceAt(PALETTES[palette], uv, seed);
            const float t = std::clamp((piece.lead - 0.03f) / 0.06f, 0.0f, 1.0f);
            const vec3 color =
                piece.color * (0.02f + 0.98f * t * t * (3.0f - 2.0f * t));  // lead lets next to nothing through
            uint8_t* texel = &image.rgba8[(size_t(y) * width + x) * 4];
            for (int c = 0; c < 3; ++c) texel[c] = srgbByte(color[c]);
            texel[3] = 255;
        }
    }
    return image;
}

}  // namespace heliograph::generate

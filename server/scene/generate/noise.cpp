#include "server/scene/generate/noise.h"

#include <cmath>

namespace heliograph::generate {

namespace {

int wrapped(int value, int period) {
    const int r = value % period;
    return r < 0 ? r + period : r;
}

float smooth(float t) { return t * t * (3.0f - 2.0f * t); }

}  // namespace

uint32_t Random::next() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005ull + 1442695040888963407ull;
    const uint32_t xored = uint32_t(((old >> 18u) ^ old) >> 27u), turn = uint32_t(old >> 59u);
    return (xored >> turn) | (xored << ((32u - turn) & 31u));
}

float hash01(int x, int y, uint32_t seed) {
    uint32_t h = uint32_t(x) * 0x9e3779b1u ^ uint32_t(y) * 0x85ebca77u ^ seed * 0xc2b2ae3du;
    h ^= h >> 16, h *= 0x7feb352du, h ^= h >> 15, h *= 0x846ca68bu, h ^= h >> 16;
    return float(h >> 8) * 0x1p-24f;
}

float valueNoise(vec2 p, int period, uint32_t seed) {
    const float fx = std::floor(p.x), fy = std::floor(p.y);
    const int x0 = wrapped(int(fx), period), y0 = wrapped(int(fy), period);
    const int x1 = x0 + 1 == period ? 0 : x0 + 1, y1 = y0 + 1 == period ? 0 : y0 + 1;
    const float tx = smooth(p.x - fx), ty = smooth(p.y - fy);
    const float low = hash01(x0, y0, seed) * (1.0f - tx) + hash01(x1, y0, seed) * tx;
    const float high = hash01(x0, y1, seed) * (1.0f - tx) + hash01(x1, y1, seed) * tx;
    return low * (1.0f - ty) + high * ty;
}

float fractalNoise(vec2 p, int period, int octaves, uint32_t seed) {
    float sum = 0.0f, weight = 0.0f, strength = 1.0f;
    for (int i = 0; i < octaves; ++i) {
        sum += strength * valueNoise(p, period, seed + uint32_t(i) * 101u);
        weight += strength;
        strength *= 0.5f;
        p *= 2.0f;
        period *= 2;
    }
    return sum / weight;
}

Cell cellNoise(vec2 p, int period, uint32_t seed, float jitter) {
    const int cx = int(std::floor(p.x)), cy = int(std::floor(p.y));
    float first = 1e9f, second = 1e9f, id = 0.0f;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            const int x = wrapped(cx + dx, period), y = wrapped(cy + dy, period);
            const vec2 point = vec2(float(cx + dx), float(cy + dy)) + 0.5f +
                               jitter * (vec2(hash01(x, y, seed), hash01(x, y, seed + 1u)) - 0.5f);
            const float distance = glm::length(point - p);
            if (distance < first) second = first, first = distance, id = hash01(x, y, seed + 2u);
            else if (distance < second) second = distance;
        }
    }
    return {first, second - first, id};
}

}  // namespace heliograph::generate

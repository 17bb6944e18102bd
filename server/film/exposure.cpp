#include "server/film/exposure.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace heliograph {

namespace {

constexpr uint32_t MOST_PIXELS = 65'536;
constexpr double LEFT_OUT = 0.1;  // of the pixels, at either end

/// Whether it is the backdrop's radiance; means of equal samples round.
bool shows(const vec4& pixel, const vec3& backdrop) {
    const vec3 far = glm::abs(vec3(pixel) - backdrop);
    const vec3 near = 1e-5f * glm::abs(backdrop);
    return far.x <= near.x && far.y <= near.y && far.z <= near.z;
}

/// Of the film's pixels that count, base 2.
std::vector<float> logLuminances(const Film& film, const std::optional<vec3>& backdrop) {
    const uvec2 size = film.resolution();
    const uint32_t rows = std::clamp(MOST_PIXELS / std::max(size.x, 1u), 1u, std::max(size.y, 1u));
    std::vector<vec4> row(size.x);
    std::vector<float> logs;
    for (uint32_t i = 0; i < std::min(rows, size.y); i++) {
        const auto y = static_cast<uint32_t>((2ull * i + 1) * size.y / (2ull * rows));
        film.develop(y, y + 1, row.data());
        for (const vec4& pixel : row) {
            const float luminance = LUMINANCE_RED * pixel.x + LUMINANCE_GREEN * pixel.y + LUMINANCE_BLUE * pixel.z;
            if (luminance > 0.0f && std::isfinite(luminance) && !(backdrop && shows(pixel, *backdrop)))
                logs.push_back(std::log2(luminance));
        }
    }
    return logs;
}

}  // namespace

std::optional<float> meteredExposure(const Film& film, const std::optional<vec3>& backdrop) {
    std::vector<float> logs = logLuminances(film, backdrop);
    if (logs.empty()) return std::nullopt;
    std::sort(logs.begin(), logs.end());
    const auto out = static_cast<size_t>(LEFT_OUT * static_cast<double>(logs.size()));
    double sum = 0.0;
    for (size_t i = out; i < logs.size() - out; i++) sum += logs[i];
    const double mean = sum / static_cast<double>(logs.size() - 2 * out);
    return std::clamp(static_cast<float>(std::log2(MID_GREY) - mean), LEAST_EXPOSURE, MOST_EXPOSURE);
}

}  // namespace heliograph

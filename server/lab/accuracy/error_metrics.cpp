#include "server/lab/accuracy/error_metrics.h"

#include "server/film/stats.h"
#include "server/lab/accuracy/flip.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace heliograph {

namespace {

constexpr double MOST_PSNR_DB = 99.0;
constexpr double TRIMMED = 0.001;        // of the pixels
constexpr double RELATIVE_FLOOR = 0.01;  // of the squared reference; Rousselle et al. 2011

void requireEqual(uvec2 a, uvec2 b) {
    if (a != b || a.x == 0 || a.y == 0) throw std::invalid_argument("pictures to compare must be of one size, not empty");
}

}  // namespace

LinearError linearError(const LinearPicture& picture, const LinearPicture& reference) {
    requireEqual(picture.resolution, reference.resolution);
    double sum = 0.0, referenceSum = 0.0, squares = 0.0, relative = 0.0;
    std::vector<double> byPixel(reference.pixels.size());
    for (size_t i = 0; i < reference.pixels.size(); i++) {
        for (int channel = 0; channel < 3; channel++) {
            const double x = picture.pixels[i][channel], r = reference.pixels[i][channel];
            sum += x;
            referenceSum += r;
            byPixel[i] += (x - r) * (x - r);
            relative += (x - r) * (x - r) / (r * r + RELATIVE_FLOOR);
        }
    }
    const auto pixels = static_cast<double>(byPixel.size());
    const double count = 3.0 * pixels;
    const double scale = referenceSum > 0.0 ? referenceSum / count : 1.0;
    const auto kept = byPixel.end() - static_cast<ptrdiff_t>(TRIMMED * pixels);
    std::nth_element(byPixel.begin(), kept - 1, byPixel.end());
    for (auto square = byPixel.begin(); square != kept; ++square) squares += *square;
    const double trimmed = squares / (3.0 * static_cast<double>(kept - byPixel.begin()));
    for (auto square = kept; square != byPixel.end(); ++square) squares += *square;
    return {std::sqrt(trimmed) / scale, relative / count, (sum - referenceSum) / count / scale,
            std::sqrt(squares / count) / scale};
}

DisplayError displayError(const DisplayImage& picture, const DisplayImage& reference) {
    requireEqual(uvec2(picture.width, picture.height), uvec2(reference.width, reference.height));
    const size_t pixels = static_cast<size_t>(reference.width) * reference.height;
    double squares = 0.0;
    std::vector<double> worst(pixels);
    for (size_t i = 0; i < pixels; i++) {
        for (size_t channel = 0; channel < 3; channel++) {
            const double difference = static_cast<double>(picture.rgba[4 * i + channel]) - reference.rgba[4 * i + channel];
            squares += difference * difference;
            worst[i] = std::max(worst[i], std::abs(difference));
        }
    }
    const double mse = squares / (3.0 * static_cast<double>(pixels));
    DisplayError error;
    error.psnrDb = mse > 0.0 ? std::min(MOST_PSNR_DB, 10.0 * std::log10(255.0 * 255.0 / mse)) : MOST_PSNR_DB;
    error.p99 = percentile(worst, 0.99);
    error.flip = mse > 0.0 ? meanFlip(flipMap(reference, picture)) : 0.0;
    return error;
}

double errorOfMean(const LinearPicture& first, const LinearPicture& second) {
    // Each lies half their distance from the mean, and that is scaled by the mean of both.
    return linearError(first, meanOf(first, second)).rmse;
}

LinearPicture meanOf(const LinearPicture& first, const LinearPicture& second) {
    requireEqual(first.resolution, second.resolution);
    LinearPicture mean = first;
    for (size_t i = 0; i < mean.pixels.size(); i++) mean.pixels[i] = 0.5f * (first.pixels[i] + second.pixels[i]);
    return mean;
}

}  // namespace heliograph

#include "server/lab/live/truth.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace heliograph {

double luminanceOf(vec3 rgb) {
    return static_cast<double>(LUMINANCE_RED) * rgb.x + static_cast<double>(LUMINANCE_GREEN) * rgb.y +
           static_cast<double>(LUMINANCE_BLUE) * rgb.z;
}

std::vector<double> luminances(const std::vector<vec4>& pixels, double white) {
    std::vector<double> all;
    all.reserve(pixels.size());
    for (const vec4& pixel : pixels) all.push_back(std::min(luminanceOf(vec3(pixel)), white));
    return all;
}

double meanSquare(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> squares;
    for (size_t i = 0; i < a.size(); i++) squares.push_back((a[i] - b[i]) * (a[i] - b[i]));
    const auto kept = squares.end() - static_cast<ptrdiff_t>(1e-3 * static_cast<double>(squares.size()));
    std::nth_element(squares.begin(), kept - 1, squares.end());
    return std::accumulate(squares.begin(), kept, 0.0) / static_cast<double>(squares.size());
}

Truth::Truth(const Reference& reference, double white) : pixels(luminances(reference.picture().pixels, white)), white(white) {
    for (double pixel : pixels) mean += pixel / static_cast<double>(pixels.size());
    // The halves are twice as far from each other as their mean is from the truth.
    ownSquare = meanSquare(luminances(reference.half(0).pixels, white), luminances(reference.half(1).pixels, white)) / 4.0;
}

double Truth::errorOf(const std::vector<double>& luminances) const {
    return std::sqrt(std::max(0.0, meanSquare(luminances, pixels) - ownSquare)) / mean;
}

double Truth::ownError() const { return std::sqrt(ownSquare) / mean; }

}  // namespace heliograph

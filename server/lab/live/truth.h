#pragma once
// What a film tells of itself is measured against: luminances of a reference, white at most, errors as Film::relativeError has them.

#include "server/lab/accuracy/reference.h"

namespace heliograph {

/// Rec. 709 luminance of linear radiance.
double luminanceOf(vec3 rgb);
/// Of each pixel, `white` at most.
std::vector<double> luminances(const std::vector<vec4>& pixels, double white);
/// Mean of the squared differences, without the thousandth that is largest. Of as many values, at least one.
double meanSquare(const std::vector<double>& a, const std::vector<double>& b);

struct Truth {
    std::vector<double> pixels;  // luminances
    double mean = 0.0, white = 0.0;
    double ownSquare = 0.0;  // mean squared error of its own

    /// Of a reference with both halves.
    Truth(const Reference& reference, double white);
    /// Relative error of these luminances, without the reference's own.
    double errorOf(const std::vector<double>& luminances) const;
    /// Relative error of its own.
    double ownError() const;
};

}  // namespace heliograph

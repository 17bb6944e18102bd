#pragma once
// How far a picture is from its reference. Definitions: docs/reference/accuracy.md, "How errors are measured".

#include "server/lab/accuracy/picture.h"

namespace heliograph {

/// On linear radiance, over all pixels and the three channels.
struct LinearError {
    /// Root of the mean squared difference over the reference's mean (normalised root mean squared error), without the thousandth
    /// of the pixels that is farthest off (least trimmed squares; P. Rousseeuw, "Least Median of Squares Regression", 1984): the
    /// few pixels with the reflection of a lamp are as good as chance, and would be all that the figure tells of.
    double rmse = 0.0;
    /// Mean of (x - r)^2 / (r^2 + 0.01): dark places count as much as light ones (relative mean squared error; F. Rousselle,
    /// C. Knaus, M. Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error Minimization", 2011, section 5).
    double relativeMse = 0.0;
    /// Mean of x over the mean of the reference, less 1: above 0 the picture is too bright.
    double bias = 0.0;
    double rmseAll = 0.0;  // `rmse` with all pixels
};

/// On display codes, RGB of 0 to 255.
struct DisplayError {
    double psnrDb = 0.0;  // 10 lg(255^2 / mean squared difference over pixels and channels); 99 at most, which equal ones have
    double p99 = 0.0;     // codes: 99 of 100 pixels differ by no more in their worst channel
    double flip = 0.0;    // mean of the FLIP map (flip.h), 0 to 1
};

/// Both of one size, at least one pixel. Where the reference is black all over, errors are those of the plain difference.
/// Throws std::invalid_argument for sizes that differ.
LinearError linearError(const LinearPicture& picture, const LinearPicture& reference);
DisplayError displayError(const DisplayImage& picture, const DisplayImage& reference);

/// The error of the mean of two pictures that are independent and equally good, told from how far they are apart: half their
/// `rmse`, since the variance of the difference is twice that of each, and that of the mean half that of each.
double errorOfMean(const LinearPicture& first, const LinearPicture& second);
/// The pixels' means.
LinearPicture meanOf(const LinearPicture& first, const LinearPicture& second);

}  // namespace heliograph

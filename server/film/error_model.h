#pragma once
// How the error of a pixel falls with its samples. They are spread evenly and cancel each other's errors, so that the standard
// error of independent samples is up to four times too large for 256. How much too large depends on what the variance comes from:
//
// - Edges through the pixel. Their error follows from the points of the R2 sequence, which all pixels share: it is known.
// - Light, occlusion, lens: the scrambled Sobol sequence in several dimensions, little better than independent samples.
//
// The share of edges is told by how far doublings of the samples moved the pixels' means. With V(n) the squared error of n samples,
// whose halves are as good as each other, the mean m(2n) is correlated with that of either half by V(2n):
//   E (m(2n) - m(n))^2 = V(n) - V(2n).
// That errors of such points are those of their discrepancy at edges: D. Mitchell, "Consequences of Stratified Sampling in
// Graphics", 1996.

#include <cstdint>
#include <span>

namespace heliograph {

/// Squared error of the mean of n samples over the variance of one, where it comes from edges alone: half planes that hit the
/// pixel, all alike likely, against their exact area. n from 1 to 65536; between powers of two as a power of n.
double edgeDecay(double samples);
/// The same for all else: n^-1.12, from pictures with indirect light and with the path integrator.
double otherDecay(double samples);
/// With this share of the variance from edges.
double errorDecay(double samples, double edgeShare);

/// A doubling of a picture's samples.
struct Doubling {
    uint32_t samples = 0;  // after it
    double moved = 0.0;    // mean square by which it moved the pixels' means, over the variance of a sample
};

constexpr uint32_t FIRST_DOUBLING = 8;  // samples; sample 0 lies in the middle of every pixel, and weighs more in fewer
constexpr double USUAL_EDGE_SHARE = 0.6;

/// The share of edges that fits best (least squares), drawn to the usual one where doublings tell little; 0 to 1. Those to less
/// than FIRST_DOUBLING samples are left out.
double edgeShare(std::span<const Doubling> doublings);

}  // namespace heliograph

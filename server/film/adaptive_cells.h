#pragma once
// Which cells of a picture at rest get more samples, where its error shall come down to a target. The fewest rays for it are those
// of which none would take more from the error elsewhere: with V(n) a cell's squared error after n samples and c the cost of one,
// -V'(n) / c is the same in all cells that are refined (J. Neyman, "On the Two Different Aspects of the Representative Method",
// 1934, for errors that fall as error_model.h says). Cells where a sample takes less than that get none.
//
// That samples decide whether there are more of them would be a bias. One pixel in 16 decides (`Film::errorParts`), for itself and
// for the other 15, whose own samples have no say. What it is for the one is measured (docs/reference/accuracy.md).

#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

/// What is known of a cell.
struct CellError {
    double square = 0.0;   // its part of the picture's squared relative error: they sum up to that of the picture
    uint32_t samples = 0;  // of each of its pixels
    double cost = 1.0;     // of one sample of all its pixels, in any unit; above 0
};

/// Samples that every cell has before its error counts for anything.
constexpr uint32_t ADAPTIVE_FROM = 16;

/// Whether each cell gets another sample on the way to the relative error `target`: none does where it is reached. Cells with
/// `mostSamples` get none whatever they lack. `edgeShare`: of error_model.h.
std::vector<bool> cellsToRefine(std::span<const CellError> cells, double target, double edgeShare, uint32_t mostSamples);

}  // namespace heliograph

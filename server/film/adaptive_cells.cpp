#include "server/film/adaptive_cells.h"

#include "server/film/error_model.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

/// A cell whose pixels agree by chance has still this part of what a cell has on average.
constexpr double LEAST_PART = 0.02;

struct Cell {
    double square, gain, power;  // gain: squared error that one sample more takes, for its cost
    bool free;                   // may get more
};

/// -d log V / d log n.
double powerAt(uint32_t samples, double edgeShare) {
    return std::log2(errorDecay(samples, edgeShare) / errorDecay(2.0 * samples, edgeShare));
}

std::vector<Cell> weighed(std::span<const CellError> cells, double edgeShare, uint32_t mostSamples) {
    double mean = 0.0;
    for (const CellError& cell : cells) mean += cell.square / static_cast<double>(cells.size());
    std::vector<Cell> all;
    all.reserve(cells.size());
    double power = 0.0;
    uint32_t samples = 0;
    for (const CellError& cell : cells) {
        if (cell.samples != samples) power = powerAt(samples = cell.samples, edgeShare);
        const double square = std::max(cell.square, LEAST_PART * mean);
        all.push_back({square, power * square / (cell.samples * cell.cost), power, cell.samples < mostSamples});
    }
    return all;
}

/// The picture's squared error once every cell has been refined until a sample gains no more than `least`.
double squareAt(const std::vector<Cell>& cells, double least) {
    double sum = 0.0;
    for (const Cell& cell : cells) {
        // With V = A n^-p the gain goes as n^-(p + 1).
        const bool refined = cell.free && cell.gain > least;
        sum += refined ? cell.square * std::pow(least / cell.gain, cell.power / (cell.power + 1.0)) : cell.square;
    }
    return sum;
}

}  // namespace

std::vector<bool> cellsToRefine(std::span<const CellError> cells, double target, double edgeShare, uint32_t mostSamples) {
    std::vector<bool> refine(cells.size(), false);
    double now = 0.0;
    for (const CellError& cell : cells) now += cell.square;
    if (now <= target * target) return refine;
    const std::vector<Cell> all = weighed(cells, edgeShare, mostSamples);
    double high = 0.0;
    for (const Cell& cell : all) high = std::max(high, cell.gain);
    double low = high * 1e-12;
    for (int step = 0; step < 60; step++) {
        const double middle = std::sqrt(low * high);
        (squareAt(all, middle) > target * target ? high : low) = middle;
    }
    for (size_t i = 0; i < all.size(); i++) refine[i] = all[i].free && all[i].gain > low;
    return refine;
}

}  // namespace heliograph

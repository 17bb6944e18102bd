// What a film tells of its own error (error_model.h).

#include "server/film/film.h"

#include "server/film/error_model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace heliograph {

namespace {

constexpr double TRIMMED = 0.001;  // of the pixels: as lab/accuracy/error_metrics.h does

}  // namespace

void Film::developWithVariance(uint32_t firstRow, uint32_t lastRow, double edges, vec4* pixels) const {
    develop(firstRow, lastRow, pixels);
    Reading reading(*this);
    uint32_t samples = 0;
    double decay = 1.0;
    for (uint32_t y = firstRow; y < lastRow; y++) {
        for (uint32_t x = 0; x < resolution_.x; x++, pixels++) {
            const Block& block = blocks_[static_cast<size_t>(y / BLOCK) * blockCount_.x + x / BLOCK];
            pixels->w = -1.0f;
            if (block.samples < 2) continue;
            if (block.samples != samples) decay = errorDecay(block.samples, edges);
            samples = block.samples;
            const glm::dvec4& sum = sums_[static_cast<size_t>(y) * resolution_.x + x];
            const double mean = luminanceOf(sum) / samples;
            pixels->w = static_cast<float>(std::max(0.0, sum.w - mean * mean * samples) / (samples - 1.0) * decay);
        }
    }
}

template <typename Visit>
void Film::forJudged(std::optional<double> edges, uint32_t step, Visit visit) const {
    uint32_t samples = 0;
    double decay = 1.0;
    for (uint32_t y = 0; y < resolution_.y; y++) {
        for (uint32_t x = (y * 5) % step; x < resolution_.x; x += step) {
            const Block& block = blocks_[static_cast<size_t>(y / BLOCK) * blockCount_.x + x / BLOCK];
            if (edges && block.samples != samples) decay = errorDecay(block.samples, *edges);
            samples = block.samples;
            const glm::dvec4 sum = sumOf(block, static_cast<size_t>(y) * resolution_.x + x);
            const double mean = luminanceOf(sum) / samples;
            const double variance = std::max(0.0, sum.w - mean * mean * samples) / (samples - 1.0);
            // Where it is white by more than it may err, it is white. A single sample that is far too bright does not make it so.
            const bool white = mean - white_ > std::sqrt(variance / samples);
            visit(x, y, std::min(mean, white_), white ? 0.0 : variance * decay);
        }
    }
}

Film::Judged Film::judged(std::optional<double> edges, uint32_t step) const {
    Judged judged;
    forJudged(edges, step, [&](uint32_t, uint32_t, double mean, double square) {
        judged.means += mean;
        judged.squares.push_back(square);
    });
    return judged;
}

uint32_t Film::finestStep() const {
    constexpr size_t ENOUGH = 50'000;  // pixels: a sixteenth of 1280x720 are 57,600
    uint32_t step = ErrorHistory::STEP;
    while (step > 1 && pixelCount() / step < ENOUGH) step /= 2;
    return step;
}

bool Film::anyBelow(uint32_t samples) const {
    return blocks_.empty() || std::ranges::any_of(blocks_, [&](const Block& block) { return block.samples < samples; });
}

double Film::Judged::meanSquare() {
    const auto count = static_cast<double>(squares.size());
    const auto kept = squares.end() - static_cast<ptrdiff_t>(TRIMMED * count);
    std::nth_element(squares.begin(), kept - 1, squares.end());
    return std::accumulate(squares.begin(), kept, 0.0) / count;
}

double Film::Judged::largestKept() {
    const auto kept = squares.end() - static_cast<ptrdiff_t>(TRIMMED * static_cast<double>(squares.size()));
    std::nth_element(squares.begin(), kept - 1, squares.end());
    return *(kept - 1);
}

std::optional<double> Film::movedBy(uint32_t doubling) const {
    auto keeps = [&](size_t block) {
        return history_.first(block + 1)[block].doublings - doubling < ErrorHistory::KEPT;  // unsigned: not before it
    };
    Judged variances;
    forJudged(std::nullopt, ErrorHistory::STEP, [&](uint32_t x, uint32_t y, double, double square) {
        if (keeps(static_cast<size_t>(y / BLOCK) * blockCount_.x + x / BLOCK)) variances.squares.push_back(square);
    });
    const auto pixels = static_cast<double>(variances.squares.size());
    const double variance = variances.squares.empty() ? 0.0 : variances.meanSquare();
    if (!(variance > 0.0)) return std::nullopt;
    std::vector<float> moved;
    for (size_t block = 0; block < blocks_.size(); block++) {
        if (keeps(block)) moved.push_back(history_.first(block + 1)[block].moved[doubling % ErrorHistory::KEPT]);
    }
    // A pixel that is far off is alone in its block.
    const auto kept = moved.end() - static_cast<ptrdiff_t>(TRIMMED * pixels);
    std::nth_element(moved.begin(), kept - 1, moved.end());
    return std::accumulate(moved.begin(), kept, 0.0) / pixels / variance;
}

double Film::measuredEdgeShare() const {
    if (blocks_.empty() || !std::ranges::all_of(blocks_, &Block::wide)) return USUAL_EDGE_SHARE;
    // Where cells have different numbers of samples: the newest that an eighth of the picture has come to.
    std::vector<uint32_t> made;
    for (const ErrorHistory::Block& block : history_.first(blocks_.size())) made.push_back(block.doublings);
    const auto eighth = made.begin() + static_cast<ptrdiff_t>(made.size() / 8);
    std::nth_element(made.begin(), eighth, made.end(), std::greater<>());
    std::vector<Doubling> doublings;
    for (uint32_t i = *eighth; i > 0 && i + ErrorHistory::KEPT > *eighth; i--) {
        const std::optional<double> moved = movedBy(i);
        if (moved) doublings.push_back({history_.first(1)[0].first << i, *moved});
    }
    return heliograph::edgeShare(doublings);
}

double Film::edgeShare() const {
    Reading reading(*this);
    return measuredEdgeShare();
}

double Film::Judged::relativeSquare() {
    const double square = meanSquare(), mean = means / static_cast<double>(squares.size());
    // A black picture without variance is exact.
    if (!(mean > 0.0)) return square > 0.0 ? 1.0 : 0.0;
    return std::min(1.0, square / (mean * mean));
}

double Film::relativeError() const {
    Reading reading(*this);
    if (anyBelow(2)) return 1.0;
    return std::sqrt(judged(measuredEdgeShare(), finestStep()).relativeSquare());
}

std::vector<CellError> Film::errorParts() const {
    const std::vector<uint32_t> samples = cellSamples();
    Reading reading(*this);
    if (anyBelow(2)) return {};
    const double edges = measuredEdgeShare();
    Judged all = judged(edges, ErrorHistory::STEP);
    if (!(all.means > 0.0)) return {};
    const double most = all.largestKept();
    const double mean = all.means / static_cast<double>(all.squares.size());
    double scale = 1.0 / (static_cast<double>(all.squares.size()) * mean * mean);
    // How large the sum is, more pixels know.
    const double square = all.relativeSquare();
    if (square > 0.0) scale *= judged(edges, finestStep()).relativeSquare() / square;
    const uvec2 count = cellCount();
    std::vector<CellError> cells;
    cells.reserve(samples.size());
    for (uint32_t least : samples) cells.push_back({0.0, least});
    forJudged(edges, ErrorHistory::STEP, [&](uint32_t x, uint32_t y, double, double own) {
        cells[static_cast<size_t>(y / CELL_SIZE) * count.x + x / CELL_SIZE].square += scale * std::min(own, most);
    });
    return cells;
}

std::optional<ErrorMap> Film::errorMap(uvec2 cellSize) const {
    Reading reading(*this);
    if (anyBelow(2)) return std::nullopt;
    const uvec2 cells = (resolution_ + cellSize - 1u) / cellSize;
    std::vector<double> squares(static_cast<size_t>(cells.x) * cells.y, 0.0);
    std::vector<uint32_t> counts(squares.size(), 0);
    double means = 0.0;
    uint64_t pixels = 0;
    forJudged(measuredEdgeShare(), ErrorHistory::STEP, [&](uint32_t x, uint32_t y, double mean, double square) {
        const size_t cell = static_cast<size_t>(y / cellSize.y) * cells.x + x / cellSize.x;
        squares[cell] += square;
        counts[cell]++;
        means += mean;
        pixels++;
    });
    if (!(means > 0.0)) return std::nullopt;  // black: there is nothing to take shares of
    const double mean = means / static_cast<double>(pixels);
    ErrorMap map{resolution_, cellSize, {}};
    map.cells.reserve(squares.size());
    for (size_t i = 0; i < squares.size(); i++) {
        map.cells.push_back(counts[i] > 0 ? static_cast<float>(std::sqrt(squares[i] / counts[i]) / mean) : -1.0f);
    }
    return map;
}

std::vector<float> Film::cellErrors(uvec2 cellSize) const {
    Reading reading(*this);
    const uvec2 cells = (resolution_ + cellSize - 1u) / cellSize;
    std::vector<float> errors(static_cast<size_t>(cells.x) * cells.y, 0.0f);
    constexpr uint32_t STEP = 8;
    for (uint32_t y = STEP / 2; y < resolution_.y; y += STEP) {
        for (uint32_t x = 0; x < resolution_.x; x++) {
            const Block& block = blocks_[static_cast<size_t>(y / BLOCK) * blockCount_.x + x / BLOCK];
            if (block.samples < 2) continue;
            const glm::dvec4 sum = sumOf(block, static_cast<size_t>(y) * resolution_.x + x);
            const double samples = block.samples;
            const double mean = luminanceOf(sum) / samples;
            const double variance = std::max(0.0, sum.w / samples - mean * mean) / (samples - 1.0);
            // The variance of sqrt(x) is var(x) / (4 mean).
            errors[static_cast<size_t>(y / cellSize.y) * cells.x + x / cellSize.x] +=
                static_cast<float>(variance / std::max(mean, 1e-4));
        }
    }
    for (float& error : errors) error = std::sqrt(error);
    return errors;
}

}  // namespace heliograph

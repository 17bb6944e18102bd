#include "server/render/cell_reach.h"

namespace heliograph {

namespace {

constexpr uint32_t SQUARE = 8;  // pixels; tiles are no smaller

uint32_t squares(uint32_t pixels) { return (pixels + SQUARE - 1) / SQUARE; }

}  // namespace

CellReach::CellReach(uvec2 resolution)
    : resolution_(resolution), known_(size_t(squares(resolution.x)) * squares(resolution.y) + 1) {}

std::atomic<CellReach::Known>& CellReach::at(const Tile& tile) const {
    if (tile.origin.x >= resolution_.x || tile.origin.y >= resolution_.y) return known_.back();
    return known_[size_t(tile.origin.y / SQUARE) * squares(resolution_.x) + tile.origin.x / SQUARE];
}

void CellReach::note(const TileResult& result) {
    const bool goesOn = result.rays[RayKind::reflection] + result.rays[RayKind::refraction] > 0;
    std::atomic<Known>& known = at(result.tile);
    if (&known == &known_.back()) return;
    Known before = Known::nothing;
    if (goesOn) known.store(Known::goesOn, std::memory_order_relaxed);
    else known.compare_exchange_strong(before, Known::ends, std::memory_order_relaxed);  // what went on once stays
}

bool CellReach::endsAtOnce(const Tile& tile) const { return at(tile).load(std::memory_order_relaxed) == Known::ends; }

std::shared_ptr<CellReach> ReachOfView::of(const FrameRequest& request) {
    const View view{request.camera, request.previousCamera, request.effects.bits, request.resolution};
    if (!(view_ == view)) {
        view_ = view;
        reach_ = std::make_shared<CellReach>(request.resolution);
    }
    return reach_;
}

}  // namespace heliograph

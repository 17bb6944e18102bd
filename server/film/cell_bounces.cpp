#include "server/film/cell_bounces.h"

#include <algorithm>

namespace heliograph {

namespace {

constexpr uint32_t SQUARE = 8;       // pixels; tiles are no smaller
constexpr float SMALL_TURN = 0.98f;  // cosine of it; more is a jump, of which nothing can be guessed

bool nearby(const Camera& a, const Camera& b) {
    return a.fieldOfView == b.fieldOfView &&
           glm::dot(a.forward, b.forward) > SMALL_TURN * glm::length(a.forward) * glm::length(b.forward) &&
           glm::dot(a.up, b.up) > SMALL_TURN * glm::length(a.up) * glm::length(b.up);
}

uint32_t squares(uint32_t pixels) { return (pixels + SQUARE - 1) / SQUARE; }

}  // namespace

CellBounces::CellBounces(uvec2 resolution, const CellBounces* near)
    : resolution_(resolution), known_(size_t(squares(resolution.x)) * squares(resolution.y) + 1) {
    const uint32_t stepX = near ? near->pitchX_.load() : 0, stepY = near ? near->pitchY_.load() : 0;
    if (stepX == 0 || stepY == 0) return;
    const uint32_t columns = squares(resolution_.x), rows = squares(resolution_.y);
    auto ended = [&](uint32_t x, uint32_t y) { return near->known_[size_t(y) * columns + x] == Known::ends; };
    for (uint32_t y = 0; y < rows; y += stepY) {
        for (uint32_t x = 0; x < columns; x += stepX) {
            bool all = true;
            for (uint32_t j = y < stepY ? y : y - stepY; j <= y + stepY && j < rows; j += stepY)
                for (uint32_t i = x < stepX ? x : x - stepX; i <= x + stepX && i < columns; i += stepX)
                    all = all && ended(i, j);
            if (all) known_[size_t(y) * columns + x] = Known::guessed;
        }
    }
}

std::atomic<CellBounces::Known>& CellBounces::at(const Tile& tile) const {
    if (tile.origin.x >= resolution_.x || tile.origin.y >= resolution_.y) return known_.back();
    return known_[size_t(tile.origin.y / SQUARE) * squares(resolution_.x) + tile.origin.x / SQUARE];
}

void CellBounces::note(const TileResult& result) {
    const bool goesOn = result.rays[RayKind::reflection] + result.rays[RayKind::refraction] > 0;
    std::atomic<Known>& known = at(result.tile);
    if (&known == &known_.back()) return;
    if (result.tile.origin == uvec2(0)) {  // as large as any
        pitchX_ = squares(result.tile.size.x);
        pitchY_ = squares(result.tile.size.y);
    }
    if (goesOn) return known.store(Known::goesOn, std::memory_order_relaxed);
    for (Known before : {Known::nothing, Known::guessed})  // what went on once stays
        known.compare_exchange_strong(before, Known::ends, std::memory_order_relaxed);
}

bool CellBounces::endsAtOnce(const Tile& tile) const {
    const Known known = at(tile).load(std::memory_order_relaxed);
    return known == Known::ends || known == Known::guessed;
}

std::shared_ptr<CellBounces> ViewBounces::of(const FrameRequest& request) {
    const View view{request.camera, request.previousCamera, request.effects.bits, request.resolution};
    std::lock_guard lock(mutex_);
    const auto same = std::ranges::find(views_, view, [](const auto& known) -> const View& { return known.first; });
    if (same != views_.end()) {
        std::rotate(views_.begin(), same, same + 1);
        return views_.front().second;
    }
    const auto near = std::ranges::find_if(views_, [&](const auto& known) {
        return known.first.effects == view.effects && known.first.resolution == view.resolution &&
               nearby(known.first.camera, view.camera);
    });
    auto bounces = std::make_shared<CellBounces>(request.resolution, near != views_.end() ? near->second.get() : nullptr);
    if (views_.size() == MOST) views_.pop_back();
    views_.emplace_front(view, bounces);
    return bounces;
}

void ViewBounces::forget() {
    std::lock_guard lock(mutex_);
    views_.clear();
}

}  // namespace heliograph

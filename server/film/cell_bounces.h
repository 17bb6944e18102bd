#pragma once
// What a view's paths have reached so far, by tile: those that all ended at the first surface they met, and those that went on
// (mirrors, glass, blended surfaces). Devices use it to choose a cheaper program for the former. It is a guess about samples
// to come, never a promise: a sample may meet what none met before, and a device has to notice that.

#include "server/request/frame_request.h"
#include "server/film/tile.h"

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace heliograph {

/// Of one view: nothing that it depends on changes. All from any thread.
class CellBounces {
public:
    /// `near`: of a view nearby, of the same size. Tiles that ended at once there, with all of their neighbours, are guessed to do
    /// so here.
    explicit CellBounces(uvec2 resolution, const CellBounces* near = nullptr);

    void note(const TileResult& result);
    /// Whether every path of that tile has ended at its first surface, in all passes so far, or is guessed to; false where
    /// nothing is known.
    bool endsAtOnce(const Tile& tile) const;

private:
    enum class Known : uint8_t { nothing, guessed, ends, goesOn };
    /// Known::nothing forever for tiles that are not in the picture.
    std::atomic<Known>& at(const Tile& tile) const;

    const uvec2 resolution_;                         // pixels
    mutable std::vector<std::atomic<Known>> known_;  // by the origin of the tile, in squares of 8 pixels; then one for others
    std::atomic<uint32_t> pitchX_{0}, pitchY_{0};    // of the tiles; squares; 0: none was noted
};

/// Of the views that were rendered last: the same while a view is the same (camera, effects, size), a new one when anything has
/// moved. After a small move of the camera alone it begins with a guess. All from any thread.
class ViewBounces {
public:
    std::shared_ptr<CellBounces> of(const FrameRequest& request);
    /// The scene is another one.
    void forget();

private:
    static constexpr size_t MOST = 16;  // some 30 kB each

    struct View {
        Camera camera;
        std::optional<Camera> before;
        uint64_t effects = 0;
        uvec2 resolution{0, 0};
        bool operator==(const View&) const = default;
    };
    std::mutex mutex_;
    std::deque<std::pair<View, std::shared_ptr<CellBounces>>> views_;  // the latest first
};

}  // namespace heliograph

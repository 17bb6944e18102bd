#pragma once
// A renderer of tiles. Every kind of worker is one: a CPU, a GPU, a node far away.

#include "server/base/progress.h"
#include "server/render/frame_request.h"
#include "server/render/tile.h"

#include <functional>
#include <memory>
#include <span>
#include <stop_token>

namespace heliograph {

struct DeviceInfo {
    std::string name;     // "embree", "vulkan:0"
    std::string details;  // for people: processor, driver, packet width
    std::string silicon;  // devices with the same word share processors
    uint32_t workers = 1; // tiles in work at once
};

/// Takes each finished tile; called from the device's own threads, possibly several at once.
using TileSink = std::function<void(TileResult&&)>;

class Device {
public:
    virtual ~Device() = default;
    virtual DeviceInfo info() const = 0;
    /// Of what will render under these settings, once it is prepared.
    virtual DeviceInfo infoFor(const Settings& settings) const { return static_cast<void>(settings), info(); }
    /// Makes the scene resident and builds what tracing needs; replaces the scene held before. Throws std::runtime_error
    /// or InputError; the device then holds no scene.
    virtual void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) = 0;
    /// Makes ready what these settings will need in `render`, where that may take long; throws as `load` does. Not needed:
    /// `render` does it otherwise. May run beside `render`.
    virtual void prepare(const Settings& settings) { static_cast<void>(settings); }
    /// Renders the tiles in the order given and returns when all are delivered or `stop` was asked for (tiles not begun
    /// are then left out). Must not be called while load runs. Throws when the device is lost.
    virtual void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                        std::stop_token stop) = 0;
};

}  // namespace heliograph

#pragma once
// Who renders the tiles of a pass: the devices of one scene together (device_set.h).

#include "server/device/device.h"
#include "server/film/view_memory.h"
#include "server/schedule/schedule_report.h"

namespace heliograph {

class Renderer {
public:
    virtual ~Renderer() = default;
    /// Of the device that `load` was asked for.
    virtual DeviceInfo info() const = 0;
    /// Of what will render under these settings.
    virtual DeviceInfo infoFor(const Settings& settings) const = 0;
    /// As Device::load.
    virtual void load(std::shared_ptr<const Scene> scene, const Settings& settings, const Progress& progress) = 0;
    /// As Device::prepare.
    virtual void prepare(const Settings& settings) = 0;
    /// Renders the tiles, one cell each, and returns who did what, when all are delivered or `stop` was asked for. The sink gets
    /// each tile once, from any thread. Learns in `view` what the cells cost. Throws std::runtime_error when nobody can render
    /// them, and what the sink threw.
    virtual ScheduleReport render(const FrameRequest& request, std::span<const Tile> tiles, ViewMemory& view,
                                  const TileSink& sink, std::stop_token stop) = 0;
    /// As Device::denoise, by the device that renders under these settings, if it is one alone. False: nobody did it.
    virtual bool denoise(const Settings& settings, DenoiseJob& job) = 0;
    /// As Device::depthAlong.
    virtual DepthAnswer depthAlong(const ViewRay& ray) = 0;
};

}  // namespace heliograph

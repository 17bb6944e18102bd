#pragma once
// A renderer of tiles. Every kind of worker is one: a CPU, a GPU, a node far away.

#include "server/base/progress.h"
#include "server/request/device_rows.h"
#include "server/request/frame_request.h"
#include "server/film/tile.h"

#include <functional>
#include <memory>
#include <new>
#include <span>
#include <stop_token>

namespace heliograph {

struct DeviceInfo {
    std::string name;      // of its row in the device table, "embree", "vulkan:0"
    std::string details;   // for people: processor, driver, packet width
    std::string hardware;  // devices with the same word share processors
    uint32_t workers = 1;  // tiles in work at once
    // For the scheduler:
    uint32_t streams = 1;         // calls of renderStream that are worth making side by side
    uint32_t coresPerStream = 0;  // processor cores that a stream wants for itself, if it is none of the processor's own
    double batchSeconds = 0.0;    // fixed cost of one call: submission, wake-up, the longest path of a kernel
    double roundTrip = 0.0;       // seconds on the wire, there and back; 0 for a local device
    bool overlaps = false;        // one call of `render` keeps it busier than its streams do, while nobody else works
    bool stampsTiles = true;      // TileResult::seconds add up to the time of the stream; else only the call can be timed
    bool queues = false;          // a call waits for those before it: the tiles' stamps are the device's time for it alone
    bool drawsWhole = false;      // a call costs as much for one tile as for all: a pass is one call
    /// As its row says; what the table doesn't have is a node of elsewhere.
    DeviceKind kind() const {
        const DeviceRow* row = deviceRow(name);
        return row ? row->kind : DeviceKind::node;
    }
};

/// How fast a device can begin on a kind of request that it has not rendered before.
enum class Warmth {
    cold,     // `render` waits until something is compiled
    generic,  // renders at once, slower than it will after `warmUp`
    warm,
};

/// Takes each finished tile; called from the device's own threads, possibly several at once.
using TileSink = std::function<void(TileResult&&)>;

/// What a device says of one ray.
struct DepthAnswer {
    bool known = false;            // false: this device cannot tell
    std::optional<double> depth;   // to the nearest surface, in lengths of the ray's direction; nothing where there is none
    uint32_t instance = NO_INDEX;  // of the scene, that was met
    uint32_t triangle = NO_INDEX;  // counted from its instance's first one
};

/// There is no memory for what was asked, on the device or beside it. The device is well, and other requests may fit.
class DeviceMemoryError : public std::bad_alloc {
public:
    explicit DeviceMemoryError(const std::string& what) : what_(std::make_shared<const std::string>(what)) {}
    const char* what() const noexcept override { return what_->c_str(); }

private:
    std::shared_ptr<const std::string> what_;  // copying an exception must not throw
};

struct DenoiseJob;

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
    /// Makes the first frame of such requests as fast as the next ones (drivers compile at the first dispatch). Renders
    /// nothing that anybody sees.
    virtual void warmUp(const FrameRequest& request) { static_cast<void>(request); }
    /// Whether `render` needs such a warm-up for the request. Never waits for a frame in progress.
    virtual Warmth warmth(const FrameRequest& request) const { return static_cast<void>(request), Warmth::warm; }
    /// Makes the device generic for whatever effects a viewer of the scene may switch on, as far as it can. May take seconds,
    /// beside `render`; if it throws, the device goes on without.
    virtual void standBy() {}
    /// Renders the tiles in the order given and returns when all are delivered or `stop` was asked for (tiles not begun
    /// are then left out). Must not be called while load runs. Throws when the device is lost; std::bad_alloc
    /// (DeviceMemoryError, to say more) when there is no memory for this request and the device is well.
    virtual void render(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                        std::stop_token stop) = 0;
    /// The same on one of the device's streams: as many calls as it has streams run side by side, each from a thread of its
    /// own.
    virtual void renderStream(const FrameRequest& request, std::span<const Tile> tiles, const TileSink& sink,
                              std::stop_token stop) {
        render(request, tiles, sink, stop);
    }
    /// Filters the picture (denoise/denoiser.h) on the device, with the bits that processors make as far as its rounding is theirs.
    /// False, and nothing changes, where it has no filter of its own. May run beside `render`. Throws as `render` does.
    virtual bool denoise(DenoiseJob& job) { return static_cast<void>(job), false; }
    /// Traces one ray through the scene that is resident; no part of any frame. May run beside `render`, for microseconds.
    virtual DepthAnswer depthAlong(const ViewRay& ray) { return static_cast<void>(ray), DepthAnswer{}; }
};

}  // namespace heliograph

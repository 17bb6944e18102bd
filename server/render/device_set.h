#pragma once
// The devices of one scene as one renderer: a frame goes to the device that its settings name, or with `hybrid` to all that are
// there, always through the tile scheduler: a device alone is a team of one. A device gets the scene when it is first asked for. One
// that fails is set aside, and its frame goes on elsewhere.

#include "server/render/renderer.h"
#include "server/render/tile_scheduler.h"

namespace heliograph {

/// Tells people about a device that was set aside, in one line.
using DeviceNotice = std::function<void(const std::string& device, const std::string& what)>;

/// What there is to choose from. Safe from all threads.
struct DeviceOffer {
    std::vector<std::string> words;  // of the setting `device`, those that work here
    /// The device that the setting means; words that mean the same device have one name. "hybrid" for all of `team`.
    std::function<std::string(const Settings&)> nameOf;
    /// Throws InputError for a device that is not there, std::runtime_error if it cannot start.
    std::function<std::unique_ptr<Device>(const std::string& name)> make;
    std::vector<std::string> team;  // devices of hybrid, the one that is ready soonest first
    /// Devices that come and go: nodes of the pool that may render now. They take part in hybrid and in the teams POOL and
    /// POOLED. Empty where there is no pool.
    std::function<std::vector<std::string>()> nodes = {};
    std::string own = {};  // of this machine, that renders beside the nodes in POOLED
    std::string fallback;  // that takes over from a traced device that compiles or failed; empty: none does
};

/// Names that `nameOf` may return beside those of devices: the nodes alone, for which the fallback stands in while none can render;
/// the nodes and this machine's own device.
inline constexpr std::string_view POOL = "pool", POOLED = "pooled";

struct DeviceSetOptions {
    DeviceNotice notice;
    bool patient = false;  // hybrid waits for all its devices, instead of beginning with those that are ready
    bool forced = false;   // every device takes part in hybrid, whatever it gains; for benchmarks
};

/// `load` gives the scene to the device that its settings name; the others get it in `prepare`, or in `render` for want of
/// it; hybrid's get it in the background, so does the fallback of a traced device unless the set is patient. A device that
/// could not be started or loaded is tried again when it is asked for by name again, unless there is a fallback. The scheduler
/// outlives the set.
std::unique_ptr<Renderer> makeDeviceSet(DeviceOffer offer, TileScheduler& scheduler, DeviceSetOptions options = {});

}  // namespace heliograph

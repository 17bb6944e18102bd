#pragma once
// What all views and sessions share, as they see it: scenes, devices, memory for pictures, the other views.

#include "server/base/machine.h"
#include "server/loop/finished_frame.h"
#include "server/scene/load/scene_source.h"
#include "server/viewer/metrics.h"

#include <exception>
#include <functional>

namespace heliograph {

class View;
class Views;

/// How the opening of a scene tells a view about itself; from any thread.
struct SceneListener {
    std::function<void(const std::string& what, double share)> progress;
    std::function<void(std::shared_ptr<ResidentScene>)> ready;
    std::function<void(const std::string& why, std::exception_ptr error)> failed;
};

/// Safe from all threads; never called with a lock of a session or a view held.
class SessionHost {
public:
    virtual ~SessionHost() = default;
    /// The scenes on offer; the first is where a viewer starts.
    virtual std::vector<SceneRecipe> scenes() const = 0;
    /// Scenes beside those, which nobody is told of: whether this may be the name of one.
    virtual bool opensToo(const std::string&) const { return false; }
    /// Words of the setting `device` that a viewer may choose.
    virtual std::vector<std::string> devices() const = 0;
    /// Opens one of them in the background. After the returned ticket is gone the listener is not called any more (a call
    /// in progress may still end). Throws InputError when no further scene fits.
    virtual std::shared_ptr<void> openScene(const std::string& name, SceneListener listener) = 0;
    /// Grants a view pixels of a picture instead of what it had before, however many look at it. Returns how many: fewer
    /// than `wanted` where the memory for pictures does not suffice, at least 1.
    virtual uint64_t grantPixels(uint32_t view, uint64_t wanted) = 0;
    /// Somebody looks at the view as long as the returned ticket lives. Null where the memory for pictures does not suffice for
    /// the bytes that would be made for it; never for the first one.
    virtual std::shared_ptr<void> look(uint32_t view) = 0;
    /// Nobody looks at it any more: its pixels are free again, and it is destroyed where nobody waits for its threads.
    virtual void viewEnded(std::shared_ptr<View> view) = 0;
    /// Who looked at it last has gone and may come back: that happens after some time, unless somebody looks at it then.
    virtual void viewLeft(std::shared_ptr<View> view) = 0;
    virtual size_t viewerCount() const = 0;
    /// Memory of the server, as of a moment ago.
    virtual uint64_t residentBytes() const { return heliograph::residentBytes(); }
    virtual Views& views() = 0;
    virtual Turns& turns() = 0;
    virtual Metrics& metrics() = 0;
    /// What `stats` says of render nodes; null where there is no pool.
    virtual nlohmann::ordered_json poolReport() const { return nullptr; }
};

}  // namespace heliograph

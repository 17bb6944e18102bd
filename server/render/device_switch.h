#pragma once
// The devices that viewers choose between, behind one: each frame goes to the device that its settings name. A device gets
// the scene when it is first asked for.

#include "server/render/device.h"
#include "server/render/spare_device.h"

namespace heliograph {

/// What there is to choose from. Safe from all threads.
struct DeviceOffer {
    std::vector<std::string> words;  // of the setting `device`, those that work here
    /// The device that the setting means; words that mean the same device have one name.
    std::function<std::string(const Settings&)> nameOf;
    /// Throws InputError for a device that is not there, std::runtime_error if it cannot start.
    std::function<std::unique_ptr<Device>(const std::string& name, DeviceNotice notice)> make;
};

/// `load` gives the scene to the device that its settings name; the others get it in `prepare`, or in `render` for want of
/// it. A device that could not be started or loaded is tried again when it is asked for again.
std::unique_ptr<Device> makeDeviceSwitch(DeviceOffer offer, DeviceNotice notice = {});

}  // namespace heliograph

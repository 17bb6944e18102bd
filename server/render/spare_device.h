#pragma once
// A device with another one that steps in: when the first fails, the tiles that it did not deliver are made by the spare, so
// that the frame is complete, and the spare goes on from there.

#include "server/render/device.h"

namespace heliograph {

/// Told once, in one line for people, when the first device was set aside.
using DeviceNotice = std::function<void(const std::string& what)>;

/// The spare gets the scene only when it is needed. InputErrors are not failures of the device and pass through, except that
/// a scene which the first device cannot hold goes to the spare.
std::unique_ptr<Device> makeSpareDevice(std::unique_ptr<Device> first, std::unique_ptr<Device> spare, DeviceNotice notice = {});

}  // namespace heliograph

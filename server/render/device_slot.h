#pragma once
// One device of a set: from the day it is first asked for until it is set aside. Private to the device set.

#include "server/device/device.h"
#include "server/render/calls_in_flight.h"

#include <mutex>

namespace heliograph {

struct DeviceSlot {
    explicit DeviceSlot(std::string what) : name(std::move(what)) {}

    const std::string name;
    std::mutex loading;  // held while the device gets the scene
    const std::shared_ptr<CallsInFlight> inFlight = std::make_shared<CallsInFlight>();

    std::mutex mutex;                // of all below
    std::shared_ptr<Device> device;  // null until it holds the scene
    std::string aside;               // why it is set aside; empty = it is not
    bool busy = false;               // somebody gets it ready in the background
    bool blocked = false;            // and frames would wait for that
    bool stalls = false;             // it was waited for in vain

    std::shared_ptr<Device> ready() {
        std::lock_guard lock(mutex);
        return device;
    }
    std::string failure() {
        std::lock_guard lock(mutex);
        return aside;
    }
    /// Whether it still works for an earlier frame. A batch that was only late is waited for (`late` seconds), a stall once.
    bool owes(double late) {
        bool once;
        {
            std::lock_guard lock(mutex);
            once = !stalls;
        }
        const bool owing = !inFlight->wait(once ? late : 0.0);
        std::lock_guard lock(mutex);
        return stalls = owing;
    }
};

}  // namespace heliograph

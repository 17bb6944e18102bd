#pragma once
// The kinds of devices as rows of device_table.inc: what is known of a device by its name alone.

#include "server/request/settings.h"

#include <span>

namespace heliograph {

enum class DeviceKind { processor, gpu, preview, node };
enum class DeviceSide { cpu, gpu };

/// Names of the rows, so that code which means one of them compiles only while the table has it.
namespace device_name {
#define DEVICE(name, bit, kind, side, words, onSwitch, standIn, make) inline constexpr std::string_view name = #name;
#include "server/request/device_table.inc"
}  // namespace device_name

struct DeviceRow {
    std::string_view name;
    uint32_t bit = 0;  // position in a frame header's `devices`
    DeviceKind kind = DeviceKind::processor;
    std::string_view kindWord;
    DeviceSide side = DeviceSide::cpu;
    std::string_view sideWord;
    std::string_view words;               // "vulkan|vulkan:0": of the setting `device`
    bool Settings::*takesPart = nullptr;  // in hybrid; null: it never does
    std::string_view standIn;             // row that renders while this one can't; "": none
};

/// All rows, in the table's order.
std::span<const DeviceRow> deviceRows();
/// Row of the device of that name, "embree" or "vulkan:0"; null where the table has none.
const DeviceRow* deviceRow(std::string_view device);
/// Bit of the device in a frame's header. What the table doesn't have counts as a node of elsewhere, bit 3.
uint32_t deviceBit(std::string_view device);
/// Name of the one of several devices of a row, "vulkan:1".
std::string numberedDevice(std::string_view row, uint32_t number);
/// Whether the settings leave nobody for hybrid.
bool nobodyTakesPart(const Settings& settings);
/// Whether the settings take the device out of hybrid.
bool switchedOff(std::string_view device, const Settings& settings);

}  // namespace heliograph

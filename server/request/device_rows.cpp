#include "server/request/device_rows.h"

#include <algorithm>

namespace heliograph {

namespace {

/// What a row may name as a switch: one of the settings, or `none`.
struct DeviceSettings : Settings {
    bool none;
};
constexpr bool Settings::*deviceSwitch(bool Settings::*setting) { return setting; }
constexpr bool Settings::*deviceSwitch(bool DeviceSettings::*) { return nullptr; }

constexpr std::string_view nameOr(std::string_view word) { return word == "none" ? "" : word; }

constexpr DeviceRow DEVICE_ROWS[] = {
#define DEVICE(name, bit, kind, side, words, onSwitch, standIn, make)                                                        \
    {#name,           bit, DeviceKind::kind, #kind, DeviceSide::side, #side, words, deviceSwitch(&DeviceSettings::onSwitch), \
     nameOr(#standIn)},
#include "server/request/device_table.inc"
};

constexpr uint32_t ELSEWHERE = 3;  // bit of what the table does not have

}  // namespace

std::span<const DeviceRow> deviceRows() { return DEVICE_ROWS; }

const DeviceRow* deviceRow(std::string_view device) {
    const auto found = std::ranges::find(DEVICE_ROWS, device.substr(0, device.find(':')), &DeviceRow::name);
    return found == std::end(DEVICE_ROWS) ? nullptr : &*found;
}

uint32_t deviceBit(std::string_view device) {
    const DeviceRow* row = deviceRow(device);
    return 1u << (row ? row->bit : ELSEWHERE);
}

std::string numberedDevice(std::string_view row, uint32_t number) { return std::string(row) + ":" + std::to_string(number); }

bool nobodyTakesPart(const Settings& settings) {
    return std::ranges::none_of(DEVICE_ROWS, [&](const DeviceRow& row) { return row.takesPart && settings.*row.takesPart; });
}

bool switchedOff(std::string_view device, const Settings& settings) {
    const DeviceRow* row = deviceRow(device);
    return row && row->takesPart && !(settings.*row->takesPart);
}

}  // namespace heliograph

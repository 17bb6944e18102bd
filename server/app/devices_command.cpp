#include "server/app/devices_command.h"

#include "server/app/devices.h"
#include "server/device/vulkan/trace/vulkan_device.h"
#include "server/request/device_rows.h"

#include <CLI/CLI.hpp>

#include <iostream>
#include <memory>

namespace heliograph {

namespace {

/// A device that no driver has to be asked for.
nlohmann::ordered_json ownRow(const std::string& name) {
    nlohmann::ordered_json row = {{"name", name}, {"kind", name}};
    try {
        DeviceInfo info = makeNamed(name)->info();
        row["details"] = info.details;
        row["threads"] = info.workers;
        row["refused"] = nullptr;
    } catch (const std::exception& error) {
        row["refused"] = error.what();
    }
    return row;
}

nlohmann::ordered_json vulkanRow(const PhysicalDevice& device) {
    nlohmann::ordered_json row = {{"name", numberedDevice(device_name::vulkan, device.index)},
                                  {"kind", device_name::vulkan},
                                  {"details", device.name},
                                  {"type", device.type},
                                  {"driver", device.driver},
                                  {"api", device.api},
                                  {"memory_bytes", device.memoryBytes},
                                  {"buffer_range", device.bufferRange},
                                  {"texel_elements", device.texelElements},
                                  {"subgroup_size", device.subgroupSize},
                                  {"graphics", device.graphics},
                                  {"ray_tracing_pipeline", device.rayTracingPipeline}};
    row["refused"] = device.refused.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(device.refused);
    return row;
}

std::string mebibytes(const nlohmann::ordered_json& bytes) { return std::to_string(bytes.get<uint64_t>() >> 20) + " MiB"; }

}  // namespace

nlohmann::ordered_json deviceList() {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const DeviceRow& row : deviceRows()) {
        if (row.kind == DeviceKind::processor) list.push_back(ownRow(std::string(row.name)));
    }
    std::string why;
    for (const PhysicalDevice& device : listVulkanDevices(why)) list.push_back(vulkanRow(device));
    if (!why.empty()) list.push_back({{"name", device_name::vulkan}, {"kind", device_name::vulkan}, {"refused", why}});
    return list;
}

int runDevices(bool json, std::ostream& out) {
    nlohmann::ordered_json list = deviceList();
    if (json) {
        out << list.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
        return 0;
    }
    for (const auto& row : list) {
        out << row["name"].get<std::string>() << (row["refused"].is_null() ? "" : "  (cannot be used)") << "\n";
        if (row.contains("details")) out << "  " << row["details"].get<std::string>() << "\n";
        if (row.contains("driver"))
            out << "  " << row["type"].get<std::string>() << ", " << row["driver"].get<std::string>() << ", Vulkan "
                << row["api"].get<std::string>() << "\n  memory " << mebibytes(row["memory_bytes"]) << ", largest buffer "
                << mebibytes(row["buffer_range"]) << "\n";
        if (!row["refused"].is_null()) out << "  " << row["refused"].get<std::string>() << "\n";
    }
    return 0;
}

void addDevicesCommand(CLI::App& app, std::function<int()>& run) {
    auto json = std::make_shared<bool>(false);
    CLI::App* command = app.add_subcommand("devices", "List what can render here");
    command->add_flag("--json", *json, "Print JSON");
    command->callback([&run, json] { run = [json] { return runDevices(*json, std::cout); }; });
}

}  // namespace heliograph

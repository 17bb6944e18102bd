#pragma once
// `heliograph devices`: what could render here, and why what is refused is.

#include <nlohmann/json.hpp>

#include <functional>
#include <iosfwd>

namespace CLI {
class App;
}

namespace heliograph {

/// [{name, kind, details, type, driver, api, memory_bytes, buffer_range, texel_elements, subgroup_size, ray_tracing_pipeline,
/// refused}]; `refused` is null for what can be used. Fields that do not apply are left out.
nlohmann::ordered_json deviceList();
int runDevices(bool json, std::ostream& out);
/// Declares the command; when it was given, `run` runs it.
void addDevicesCommand(CLI::App& app, std::function<int()>& run);

}  // namespace heliograph

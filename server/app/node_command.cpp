#include "server/app/node_command.h"

#include "server/app/devices.h"
#include "server/app/pool_devices.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/base/text.h"
#include "server/operations/memory.h"
#include "server/operations/notify.h"
#include "server/operations/signals.h"
#include "server/pool/nats_transport.h"
#include "server/pool/node/render_node.h"

#include <CLI/CLI.hpp>

#include <unistd.h>

#include <cstdlib>
#include <iostream>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto SHUTDOWN_LIMIT = 1000ms;  // for the batch in work

struct NodeOptions {
    BrokerOptions broker;
    std::vector<std::string> devices;
    std::string name;
    std::string cache = "auto";
    uint64_t sceneMib = 0;
    double pace = 0.0;
    bool logJson = false;
    std::string logLevel = "info";
};

std::string hostName() {
    char name[256] = {};
    return gethostname(name, sizeof name - 1) == 0 && name[0] != 0 ? name : "node";
}

/// $HELIOGRAPH_CACHE, else $XDG_CACHE_HOME/heliograph, else ~/.cache/heliograph; empty where none of them is set.
std::filesystem::path cacheFolder() {
    auto variable = [](const char* name) {
        const char* value = std::getenv(name);
        return std::string(value ? value : "");
    };
    if (const char* own = std::getenv("HELIOGRAPH_CACHE")) return own;
    if (const std::string xdg = variable("XDG_CACHE_HOME"); !xdg.empty()) return std::filesystem::path(xdg) / "heliograph";
    if (const std::string home = variable("HOME"); !home.empty()) return std::filesystem::path(home) / ".cache/heliograph";
    return {};
}

/// All that is here or was named, as one: whatever heads ask for.
DeviceOffer nodeOffer(const std::vector<std::string>& devices) {
    DeviceOffer offer = deviceOffer(devices);
    const auto gpus = std::ranges::count_if(
        offer.team, [](const std::string& name) { return name.starts_with(device_name::vulkan) && deviceIsGpu(name); });
    const bool asked = std::ranges::find(devices, "hybrid") != devices.end();
    std::string what = offer.nameOf(Settings());
    if (devices.size() > 1 || asked || (devices.empty() && gpus > 1)) what = "hybrid";
    if (what == device_name::raster)
        throw InputError("--devices", "raster makes other pictures than the heads' devices", "embree, vulkan, hybrid or auto");
    offer.nameOf = [what](const Settings&) { return what; };
    return offer;
}

int node(const NodeOptions& options) {
    setUpAllocator();
    const Signals signals;  // first: a signal that comes early waits
    setLogJson(options.logJson);
    setLogLevel(options.logLevel);
    const DeviceOffer offer = nodeOffer(options.devices);
    RenderNodeOptions made;
    made.name = options.name.empty() ? hostName() : options.name;
    made.hardware = offer.nameOf(Settings()) + ", " + processorName();
    made.workers = usableProcessors();
    made.build = buildDigest();
    made.make = [offer] { return makeRenderer(offer); };
    if (options.cache == "auto") made.folder = cacheFolder().empty() ? "" : cacheFolder() / "scenes";
    else if (options.cache != "none") made.folder = options.cache;
    made.sceneBytes = (options.sceneMib > 0 ? options.sceneMib << 20 : usableMemory() / 3);
    made.raysPerSecond = 1e6 * options.pace;
    const std::string name = made.name, hardware = made.hardware;
    std::optional<ShutdownLimit> limit;  // lives longer than the node and its line: it watches their end
    const std::shared_ptr<Transport> transport = makeNatsTransport(options.broker, "heliograph node " + name);
    RenderNode joined(transport, std::move(made));
    std::cout << "heliograph: node " << oneLine(name) << " (" << oneLine(hardware) << ") in the pool of " << transport->peer()
              << std::endl;
    const ServiceManager manager;
    manager.ready("node of " + transport->peer());
    const auto every = std::min<std::chrono::milliseconds>(manager.watchdogEvery().value_or(500ms), 500ms);
    while (signals.wait(every) != Event::end) {
        if (manager.watchdogEvery()) manager.alive();
    }
    log().info("ending");
    manager.stopping();
    limit.emplace(signals, SHUTDOWN_LIMIT, 0);
    return 0;
}

}  // namespace

void addNodeCommand(CLI::App& app, std::function<int()>& run) {
    auto options = std::make_shared<NodeOptions>();
    CLI::App* command = app.add_subcommand("node", "Render for the heads of a pool (heliograph serve --pool)");
    addPoolOptions(*command, options->broker, true);
    command
        ->add_option("--devices", options->devices, "What renders: auto, or names of `heliograph devices` with commas between")
        ->delimiter(',')
        ->type_name("auto|LIST");
    command->add_option("--name", options->name, "What the heads call this node; else the name of the host");
    command->add_option("--scene-cache", options->cache, "Folder of scenes that were fetched before, or none")
        ->type_name("DIR")
        ->default_str("~/.cache/heliograph/scenes");
    command->add_option("--scene-size", options->sceneMib, "The largest scene that is taken; 0: a third of the memory")
        ->type_name("MIB");
    command->add_option("--pace", options->pace, "Render no faster than this, to measure pools on few cores; 0: no limit")
        ->check(CLI::Range(0.0, 1e6))
        ->type_name("MRAYS/S");
    command->add_option("--log-level", options->logLevel, "trace, debug, info, warn, error or off")
        ->check([](const std::string& level) {
            checkLogLevel(level);
            return std::string();
        });
    command->add_flag("--log-json", options->logJson, "Log as JSON, one object a line");
    command->footer(
        "Examples:\n"
        "  heliograph node --pool nats://127.0.0.1:4222\n"
        "  heliograph node --pool tls://broker.example:4222 --pool-secret secret.txt\n"
        "Ctrl-C ends the node; the heads go on without it.");
    command->callback([&run, options] { run = [options] { return node(*options); }; });
}

}  // namespace heliograph

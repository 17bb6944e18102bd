#include "server/app/serve_command.h"

#include "server/app/devices.h"
#include "server/app/offered_scenes.h"
#include "server/app/pool_devices.h"
#include "server/app/scene_options.h"
#include "server/service/service.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/base/machine.h"
#include "server/base/text.h"
#include "server/film/film_shares.h"
#include "server/operations/configuration.h"
#include "server/operations/memory.h"
#include "server/operations/notify.h"
#include "server/operations/signals.h"
#include "server/operations/socket_activation.h"
#include "server/operations/socket_options.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

// Together less than 2 s, after which service managers and people lose patience.
constexpr auto DRAIN_LIMIT = 1000ms;    // for last frames
constexpr auto SHUTDOWN_LIMIT = 700ms;  // for work in progress
constexpr auto LOOK_AROUND = 500ms;     // how often the main thread looks after the others

ServiceOptions serviceOptions(const ServeOptions& options) {
    ServiceOptions service;
    for (const std::string& setting : options.settings) service.defaults.setFromText(setting);
    const auto scenes = std::make_shared<const OfferedScenes>(options);
    service.scenes = scenes->list();
    service.openScene = [scenes](const std::string& name, const Progress& progress) { return scenes->open(name, progress); };
    service.opensToo = [scenes](const std::string& name) { return scenes->opensToo(name); };
    service.devices = deviceOffer(options.devices);
    if (!options.pool.empty()) {
        const BrokerOptions broker{options.pool,    options.poolSecret,  options.poolCa, options.poolCertificate,
                                   options.poolKey, options.poolInsecure};
        const std::shared_ptr<PoolHead> pool = joinPool(broker);
        service.devices = withPool(std::move(service.devices), pool);
        service.poolReport = [pool] { return poolJson(*pool); };
        service.poolState = [pool] { return poolState(*pool); };
    }
    std::string device = Settings::choiceWord("device", service.defaults.device);
    if (std::ranges::find(service.devices.words, device) == service.devices.words.end())
        throw InputError("--set device", device + " is not offered", "what is here and in --devices (see heliograph devices)");
    service.socket = socketOptions(options, handedOverSockets());
    service.socket.uploads = scenes->uploads();
    service.socket.files = readClientFiles(clientFolder(options.client));
    service.leastRate = static_cast<double>(options.leastRate);
    service.caps = {static_cast<uint32_t>(options.mostSamples), static_cast<uint32_t>(options.mostRays),
                    static_cast<uint32_t>(options.mostBounces)};
    log().info("limits of viewers: {} at once, {} frames a second at least, {} samples, {} rays of a kind, {} bounces",
               options.maxViewers, options.leastRate, options.mostSamples, options.mostRays, options.mostBounces);
    service.pictureBytes = filmMemory(options.filmMemoryMib << 20, usableMemory());
    const FilmBudget budget = filmBudget(service.pictureBytes, options.maxViewers);
    log().info("memory for pictures: {} MiB ({:.1f} million pixels, {:.2f} million guaranteed to each of {} viewers)",
               service.pictureBytes >> 20, 1e-6 * static_cast<double>(budget.pixels),
               1e-6 * static_cast<double>(guaranteedPixels(budget)), budget.places);
    service.keepViews = std::chrono::seconds(options.keepViewSeconds);
    service.watchdog = std::chrono::seconds(options.watchdogSeconds);
    return service;
}

/// A flag of the option's name; SCENE has none.
void addFlag(CLI::App& command, const OptionRow& row, std::vector<std::string>& values) {
    std::string name = "--" + std::string(row.name);
    if (row.name == "scene") name = "SCENE";
    if (row.name == "log-level") name += ",--log";
    if (row.isFlag()) {
        command.add_flag(name, values, std::string(row.help));
        return;
    }
    CLI::Option* option = command.add_option(name, values, std::string(row.help))->expected(1)->allow_extra_args(false);
    if (row.isList()) option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    if (row.name != "scene") option->type_name(std::string(row.type));
    const std::string usual = tomlValue(row, {});
    if (usual != "\"\"" && usual != "[]") option->default_str(usual);
}

/// The serving process between the service and those who started it: the main thread's work.
class Steward {
public:
    /// `configure` reads everything again.
    Steward(Service& service, const Signals& signals, std::function<Configuration()> configure)
        : service_(service), signals_(signals), configure_(std::move(configure)), options_(configure_().options) {}

    /// Until it is time to end; `name`: of the first scene. Throws what made that fail.
    void serve(const std::string& name) {
        const auto every = std::min<std::chrono::milliseconds>(manager_.watchdogEvery().value_or(LOOK_AROUND), LOOK_AROUND);
        while (true) {
            const Event event = signals_.wait(every);
            if (event == Event::end) return;
            if (event == Event::sceneDone) sceneDone(name);
            if (event == Event::reload) reload();
            lookAround();
            if (trim_.due(std::chrono::steady_clock::now(), service_.leftCount()))
                log().debug("{} MiB were given back to the system", returnFreeMemory() >> 20);
        }
    }

    /// Called from the service.
    void opened(std::exception_ptr failure) {
        {
            std::lock_guard lock(mutex_);
            failure_ = failure;
        }
        Signals::sceneDone();
    }

    /// Viewers are told and get their last frames; a second signal cuts that short.
    void drain() {
        log().info("ending");
        manager_.stopping();
        service_.drain(DRAIN_LIMIT);
        const auto deadline = std::chrono::steady_clock::now() + DRAIN_LIMIT;
        while (!service_.drained() && std::chrono::steady_clock::now() < deadline) {
            if (signals_.wait(10ms) == Event::end) return;
        }
    }

private:
    void sceneDone(const std::string& name) {
        std::lock_guard lock(mutex_);
        if (failure_) std::rethrow_exception(failure_);
        std::cout << "heliograph: serving " << oneLine(name) << " on " << service_.url() << std::endl;
        status_ = "serving " + name + " on " + service_.url();
        manager_.ready(status_);
    }

    /// A mistake leaves everything as it was.
    void reload() {
        manager_.reloading();
        try {
            const ServeOptions next = configure_().options;
            ServiceReload reload{socketOptions(next, handedOverSockets()), {}, std::chrono::seconds(next.watchdogSeconds)};
            for (const std::string& setting : next.settings) reload.defaults.setFromText(setting);
            service_.reload(reload);
            setLogJson(next.logJson);
            setLogLevel(next.logLevel);
            const std::string later = needsRestart(options_, next);
            if (!later.empty()) log().warn("reloaded, but these need a restart: {}", later);
            else log().info("reloaded: configuration, token, certificate");
        } catch (const std::exception& error) {
            log().error("not reloaded, all stays as it was: {}", error.what());
        }
        if (!status_.empty()) manager_.ready(status_);
    }

    /// Tells the service manager that all is well, if it is; else the log, once.
    void lookAround() {
        std::vector<std::string> stuck = service_.stuck();
        if (stuck.empty() && manager_.watchdogEvery()) manager_.alive();
        // A view that is stuck is no reason to begin the server anew.
        std::ranges::move(service_.stuckViews(), std::back_inserter(stuck));
        if (stuck == stuck_) return;
        for (const std::string& part : stuck) log().error("{}: has not moved for long", part);
        if (stuck.empty()) log().info("everything moves again");
        stuck_ = stuck;
    }

    Service& service_;
    const Signals& signals_;
    const std::function<Configuration()> configure_;
    const ServeOptions options_;  // as at the start
    std::string status_;          // once the first scene is there
    ServiceManager manager_;
    std::mutex mutex_;
    std::exception_ptr failure_;
    std::vector<std::string> stuck_;
    TrimClock trim_;
};

int serve(const ServeCommandLine& line, const CLI::App& command) {
    setUpAllocator();
    const Signals signals;  // first: a signal that comes early waits
    const Configuration configured = serveConfiguration(line, command);
    const ServeOptions& options = configured.options;
    setLogJson(options.logJson);
    setLogLevel(options.logLevel);
    if (!configured.file.empty()) log().info("configuration: {}", configured.file);
    for (const std::string& warning : configured.warnings) log().warn("{}", warning);
    ServiceOptions assembled = serviceOptions(options);
    const std::string name = assembled.scenes.front().name;
    std::optional<ShutdownLimit> limit;  // lives longer than the service: it watches its end
    Service service(std::move(assembled));
    Steward steward(service, signals, [&] { return serveConfiguration(line, command); });
    service.start([&](std::exception_ptr why) { steward.opened(why); });
    log().info("listening on {}, opening {}", service.url(), name);
    for (const ListenAddress& address : handedOverSockets())
        log().info("{} is the service manager's socket {}", textOf(address), address.name);
    try {
        steward.serve(name);
    } catch (...) {
        limit.emplace(signals, SHUTDOWN_LIMIT, 2);
        throw;
    }
    steward.drain();
    limit.emplace(signals, SHUTDOWN_LIMIT, 0);
    return 0;
}

}  // namespace

Configuration serveConfiguration(const ServeCommandLine& line, const CLI::App& command) {
    ConfigurationInputs inputs;
    if (command.count("--config") > 0) inputs.file = line.config;
    inputs.environment = processEnvironment();
    for (const auto& [name, texts] : line.values) {
        const std::string source = name == "scene" ? "SCENE" : "--" + name;
        if (!texts.empty()) inputs.flags.push_back({name, GivenValue::Kind::word, texts, source});
    }
    Configuration configuration = configure(inputs);
    if (!handedOverSockets().empty() && !configuration.sources.contains("listen")) configuration.options.listen.clear();
    return configuration;
}

void addServeFlags(CLI::App& command, ServeCommandLine& line) {
    for (const OptionRow& row : optionRows()) addFlag(command, row, line.values[std::string(row.name)]);
    command.add_option("--config", line.config, "Read options from this file, else from heliograph.toml here if there is one")
        ->type_name("FILE");
}

void addServeCommand(CLI::App& app, std::function<int()>& run) {
    auto line = std::make_shared<ServeCommandLine>();
    CLI::App* command = app.add_subcommand("serve", "Serve a scene to browsers");
    addServeFlags(*command, *line);
    command->add_flag("--print-config", line->print, "Print all options with where each comes from, and end");
    command->footer(
        "Examples:\n"
        "  heliograph serve                                 the courtyard on http://localhost:8080\n"
        "  heliograph serve model.glb --set samples=256\n"
        "  heliograph serve --listen 0.0.0.0:8080 --token-file token.txt\n"
        "Each option can stand in heliograph.toml (max-viewers = 8) or in the environment (HELIOGRAPH_MAX_VIEWERS=8), too;\n"
        "flags win over the environment, that over the file.\n"
        "Ctrl-C ends the server.\n\n" +
        settingsHelp());
    command->callback([&run, line, command] {
        run = [line, command] {
            if (!line->print) return serve(*line, *command);
            std::cout << configurationText(serveConfiguration(*line, *command));
            return 0;
        };
    });
}

}  // namespace heliograph

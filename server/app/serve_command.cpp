#include "server/app/serve_command.h"

#include "server/app/devices.h"
#include "server/app/scene_options.h"
#include "server/app/service.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/base/text.h"
#include "server/net/token.h"
#include "server/operations/configuration.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include <unistd.h>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto SHUTDOWN_LIMIT = 700ms;

/// SIGINT, SIGTERM and our own SIGUSR1 ("the first scene is there or has failed"), blocked in this thread and in all that
/// it starts, to be waited for here.
class Signals {
public:
    Signals() {
        std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to sockets that may be closed
        sigemptyset(&set_);
        for (int signal : {SIGINT, SIGTERM, SIGUSR1}) sigaddset(&set_, signal);
        pthread_sigmask(SIG_BLOCK, &set_, nullptr);
    }
    int wait() const {
        int signal = 0;
        sigwait(&set_, &signal);
        return signal;
    }
    static void sceneDone() { kill(getpid(), SIGUSR1); }

private:
    sigset_t set_;
};

/// Ends the process when shutting down takes too long: a scene that is just being read cannot be interrupted everywhere.
class ShutdownLimit {
public:
    explicit ShutdownLimit(int exitCode)
        : thread_([exitCode](std::stop_token stop) {
              std::mutex mutex;
              std::condition_variable_any over;
              std::unique_lock lock(mutex);
              over.wait_for(lock, stop, SHUTDOWN_LIMIT, [] { return false; });
              if (stop.stop_requested()) return;
              log().warn("work in progress did not end in time and is abandoned");
              log().flush();
              std::_Exit(exitCode);
          }) {}

private:
    std::jthread thread_;
};

std::string clientFolder(const std::string& given) {
    namespace fs = std::filesystem;
    if (!given.empty()) return given;
    std::error_code error;
    fs::path program = fs::read_symlink("/proc/self/exe", error);
    fs::path installed = program.parent_path() / "../share/heliograph/client";
    if (!error && fs::exists(installed / "index.html", error)) return installed.lexically_normal().string();
    fs::path built = HELIOGRAPH_CLIENT_FOLDER;
    if (fs::exists(built / "index.html", error)) return built.string();
    throw InputError("client", "not found in " + installed.lexically_normal().string() + " nor in " + built.string(),
                     "build it there (npm run build in client-web) or name its folder with --client");
}

SocketOptions socketOptions(const ServeOptions& options) {
    SocketOptions socket;
    socket.listen = parseListenAddress(options.listen);
    if (!options.tokenFile.empty()) socket.token = readTokenFile(options.tokenFile);
    if (!isLoopback(socket.listen.host) && socket.token.empty() && !options.insecure) {
        throw InputError("--listen", options.listen + " can be reached from other machines",
                         "that with --token-file FILE, or with --insecure to let everybody in; or 127.0.0.1");
    }
    if (options.certificate.empty() != options.key.empty()) {
        throw InputError(options.key.empty() ? "--tls-key" : "--tls-cert", "missing",
                         "both or neither of --tls-cert and --tls-key");
    }
    socket.certificateFile = options.certificate;
    socket.keyFile = options.key;
    socket.allowedOrigins = options.origins;
    socket.maxViewers = options.maxViewers;
    socket.files = readClientFiles(clientFolder(options.client));
    return socket;
}

ServiceOptions serviceOptions(const ServeOptions& options) {
    ServiceOptions service;
    for (const std::string& setting : options.settings) service.defaults.setFromText(setting);
    service.scenes = sceneRecipes();
    auto recipe = std::find_if(service.scenes.begin(), service.scenes.end(),
                               [&](const SceneRecipe& r) { return r.name == options.scene; });
    std::string file, fileName;
    if (recipe != service.scenes.end()) {
        std::rotate(service.scenes.begin(), recipe, recipe + 1);
    } else {
        file = options.scene;
        fileName = std::filesystem::path(file).filename().string();
        service.scenes.insert(service.scenes.begin(), {fileName, "The file given at the start of the server"});
    }
    service.openScene = [=](const std::string& name, const Progress& progress) {
        return openScene(!file.empty() && name == fileName ? file : name, options.environment, progress);
    };
    service.devices = deviceOffer(options.devices);
    std::string device = Settings::choiceWord("device", service.defaults.device);
    if (std::ranges::find(service.devices.words, device) == service.devices.words.end())
        throw InputError("--set device", device + " is not offered", "what is here and in --devices (see heliograph devices)");
    service.socket = socketOptions(options);
    return service;
}

/// What stood on the command line.
struct CommandLine {
    std::map<std::string, std::vector<std::string>> values;  // by option; those not given are empty
    std::string config;
    bool print = false;
};

/// A flag of the option's name; SCENE has none.
void addFlag(CLI::App& command, const OptionRow& row, std::vector<std::string>& values) {
    std::string name = "--" + std::string(row.name);
    if (row.name == "scene") name = "SCENE";
    if (row.name == "log-level") name += ",--log";
    if (row.isFlag()) {
        command.add_flag(name, values, std::string(row.help));
        return;
    }
    CLI::Option* option = command.add_option(name, values, std::string(row.help))->expected(1);
    if (row.isList()) option->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    if (row.name != "scene") option->type_name(std::string(row.type));
    if (!row.isList() && tomlValue(row, {}) != "\"\"") option->default_str(tomlValue(row, {}));
}

Configuration configuration(const CommandLine& line, const CLI::App& command) {
    ConfigurationInputs inputs;
    if (command.count("--config") > 0) inputs.file = line.config;
    inputs.environment = processEnvironment();
    for (const auto& [name, texts] : line.values) {
        const std::string source = name == "scene" ? "SCENE" : "--" + name;
        if (!texts.empty()) inputs.flags.push_back({name, GivenValue::Kind::word, texts, source});
    }
    return configure(inputs);
}

int printConfiguration(const CommandLine& line, const CLI::App& command) {
    std::cout << configurationText(configuration(line, command));
    return 0;
}

int serve(const CommandLine& line, const CLI::App& command) {
    const Configuration configured = configuration(line, command);
    const ServeOptions& options = configured.options;
    setLogJson(options.logJson);
    setLogLevel(options.logLevel);
    if (!configured.file.empty()) log().info("configuration: {}", configured.file);
    for (const std::string& warning : configured.warnings) log().warn("{}", warning);
    Signals signals;
    ServiceOptions assembled = serviceOptions(options);
    const std::string name = assembled.scenes.front().name;
    std::mutex mutex;
    std::exception_ptr failure;
    std::optional<ShutdownLimit> limit;  // lives longer than the service: it watches its end
    Service service(std::move(assembled));
    service.start([&](std::exception_ptr why) {
        {
            std::lock_guard lock(mutex);
            failure = why;
        }
        Signals::sceneDone();
    });
    log().info("listening on {}, opening {}", service.url(), name);
    for (int signal = signals.wait(); signal == SIGUSR1; signal = signals.wait()) {
        std::lock_guard lock(mutex);
        if (failure) {
            limit.emplace(2);
            std::rethrow_exception(failure);
        }
        std::cout << "heliograph: serving " << oneLine(name) << " on " << service.url() << std::endl;
    }
    log().info("ending");
    limit.emplace(0);
    return 0;
}

}  // namespace

void addServeCommand(CLI::App& app, std::function<int()>& run) {
    auto line = std::make_shared<CommandLine>();
    CLI::App* command = app.add_subcommand("serve", "Serve a scene to browsers");
    for (const OptionRow& row : optionRows()) addFlag(*command, row, line->values[std::string(row.name)]);
    command->add_option("--config", line->config, "Read options from this file, else from heliograph.toml here if there is one")
        ->type_name("FILE");
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
        run = [line, command] { return line->print ? printConfiguration(*line, *command) : serve(*line, *command); };
    });
}

}  // namespace heliograph

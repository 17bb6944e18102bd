#include "server/app/serve_command.h"

#include "server/app/devices.h"
#include "server/app/scene_options.h"
#include "server/app/service.h"
#include "server/base/error.h"
#include "server/base/log.h"
#include "server/net/token.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>

#include <unistd.h>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr auto SHUTDOWN_LIMIT = 700ms;

struct ServeOptions {
    std::string scene = "courtyard";
    std::string listen = "127.0.0.1:8080";
    std::vector<std::string> devices;
    std::string environment;
    std::string tokenFile;
    bool insecure = false;
    std::string certificate, key;
    std::string client;
    std::vector<std::string> origins;
    std::vector<std::string> settings;
    size_t maxViewers = MAX_VIEWERS;
    std::string logLevel = "info";
};

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

int serve(const ServeOptions& options) {
    setLogLevel(options.logLevel);
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
        std::cout << "heliograph: serving " << name << " on " << service.url() << std::endl;
    }
    log().info("ending");
    limit.emplace(0);
    return 0;
}

}  // namespace

void addServeCommand(CLI::App& app, std::function<int()>& run) {
    auto options = std::make_shared<ServeOptions>();
    CLI::App* command = app.add_subcommand("serve", "Serve a scene to browsers");
    command->add_option("SCENE", options->scene, "courtyard, cathedral, glass, cornell, or a .gltf, .glb or .obj file")
        ->capture_default_str();
    command
        ->add_option("--listen", options->listen,
                     "Address and port; port 0 takes a free one. Anything but this machine's own address needs\n"
                     "--token-file or --insecure")
        ->type_name("HOST:PORT")
        ->capture_default_str();
    command
        ->add_option("--devices", options->devices,
                     "What viewers may render with: auto for all that is here, or names of the setting device below\n"
                     "with commas between, the first of which is where they start")
        ->delimiter(',')
        ->type_name("auto|LIST");
    command->add_option("--environment", options->environment,
                        "Lat-long image (HDR, EXR, JPG, PNG) that surrounds every scene instead of its own surroundings");
    command->add_option("--set", options->settings, "What viewers start with; may be given several times")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--token-file", options->tokenFile,
                        "File whose first line is the secret that viewers have to know (open the page with #token=SECRET)");
    command->add_flag("--insecure", options->insecure, "Serve other machines without a token");
    command->add_option("--tls-cert", options->certificate, "Certificate for https (PEM)");
    command->add_option("--tls-key", options->key, "Its key (PEM)");
    command->add_option("--client", options->client, "Folder of the built browser client");
    command->add_option("--allow-origin", options->origins, "Another origin whose pages may connect, as https://example.org")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--max-viewers", options->maxViewers, "Viewers at once")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    command->add_option("--log", options->logLevel, "trace, debug, info, warn, error or off")->capture_default_str();
    command->footer(
        "Examples:\n"
        "  heliograph serve                                 the courtyard on http://localhost:8080\n"
        "  heliograph serve model.glb --set samples=256\n"
        "  heliograph serve --listen 0.0.0.0:8080 --token-file token.txt\n"
        "Ctrl-C ends the server.\n\n" +
        settingsHelp());
    command->callback([&run, options] { run = [options] { return serve(*options); }; });
}

}  // namespace heliograph

#include "server/app/program.h"

#include "server/app/bench/bench_command.h"
#include "server/app/devices_command.h"
#include "server/app/doctor_command.h"
#include "server/app/inspect_command.h"
#include "server/app/node_command.h"
#include "server/app/render_command.h"
#include "server/app/serve_command.h"
#include "server/base/error.h"
#include "server/base/text.h"
#include "server/base/version.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <functional>
#include <iostream>
#include <new>

namespace heliograph {

namespace {

constexpr int FAILED = 1;
constexpr int BAD_INPUT = 2;

int complain(const std::string& message, int code) {
    std::fprintf(stderr, "heliograph: %s\n", oneLine(message).c_str());
    return code;
}

int refuseArguments(const CLI::App& app, const CLI::ParseError& error) {
    std::string command = "heliograph";
    for (const CLI::App* part = &app; !part->get_subcommands().empty();) {
        part = part->get_subcommands().front();
        command += " " + part->get_name();
    }
    std::string found = error.what();
    // CLI11 says of an unknown command only that one is lacking.
    const std::vector<std::string> extras = app.remaining();
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && !extras.empty() && command == "heliograph") {
        found = "unknown command '" + extras.front() + "'";
    }
    return complain("command line: " + found + "; allowed: see " + command + " --help", BAD_INPUT);
}

void describe(CLI::App& app) {
    app.description("Heliograph: ray tracing on a machine far away, watched in a browser.");
    app.name("heliograph");
    app.require_subcommand(1);
    app.set_version_flag("--version", std::string("heliograph ") + programVersion(), "Print the version and end.");
    app.footer(
        "SCENE is the name of a scene that the program makes itself (courtyard, cathedral, glass, cornell) or a\n"
        ".gltf, .glb or .obj file.\n"
        "\n"
        "Examples:\n"
        "  heliograph serve courtyard                      then open http://localhost:8080\n"
        "  heliograph render glass --out glass.png --samples 64\n"
        "  heliograph inspect model.glb\n"
        "  heliograph COMMAND --help                       all options of a command\n"
        "\n"
        "Exit code: 0 done, 1 failed, 2 bad input.");
}

}  // namespace

int runProgram(int argc, const char* const* argv) {
    CLI::App app;
    std::function<int()> run;
    describe(app);
    addServeCommand(app, run);
    addNodeCommand(app, run);
    addRenderCommand(app, run);
    addInspectCommand(app, run);
    addDevicesCommand(app, run);
    addBenchCommand(app, run);
    addDoctorCommand(app, run);
    try {
        app.parse(argc, argv);
        int code = run();
        if (!std::cout.flush()) return complain("standard output: cannot be written", FAILED);
        return code;
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
        return refuseArguments(app, error);
    } catch (const InputError& error) {
        return complain(error.what(), BAD_INPUT);
    } catch (const std::bad_alloc&) {
        return complain("memory: there is not enough for this", FAILED);
    } catch (const std::exception& error) {
        return complain(error.what(), FAILED);
    }
}

}  // namespace heliograph

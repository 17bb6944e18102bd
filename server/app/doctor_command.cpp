#include "server/app/doctor_command.h"

#include "server/base/text.h"
#include "server/app/devices.h"
#include "server/app/devices_command.h"
#include "server/app/serve_command.h"
#include "server/images/image_module.h"
#include "server/operations/doctor.h"
#include "server/operations/socket_activation.h"
#include "server/operations/socket_options.h"
#include "server/scene/load/scene_source.h"

#include <iostream>
#include <memory>

namespace heliograph {

namespace {

/// Each device: what it is, and whether viewers may choose it.
void judgeDevices(const ServeOptions& options, std::vector<Finding>& findings) {
    std::vector<std::string> words;
    std::string automatic;
    findings.push_back(judgeAttempt("devices", [&] {
        const DeviceOffer offered = deviceOffer(options.devices);
        words = offered.words;
        automatic = offered.nameOf(Settings());
        return "viewers may choose " + joined(words) + "; auto is " + automatic;
    }));
    for (Finding& finding : judgeDeviceRows(deviceList(), words, automatic)) findings.push_back(std::move(finding));
}

Finding judgeImageModule() {
    Finding module = judgeAttempt("picture module", [] {
        imageModule();
        return std::string("found");
    });
    if (module.kind == Finding::Kind::bad) module.kind = Finding::Kind::note;
    module.means = "for Radiance HDR and OpenEXR alone";
    return module;
}

std::vector<Finding> examine(const ServeCommandLine& line, const CLI::App& command) {
    std::vector<Finding> findings;
    Configuration configured;
    findings.push_back(judgeAttempt("configuration", [&] {
        configured = serveConfiguration(line, command);
        return configured.file.empty() ? std::string("no file") : configured.file;
    }));
    const ServeOptions& options = configured.options;
    for (const std::string& warning : configured.warnings)
        findings.push_back({"environment", Finding::Kind::note, warning, ""});
    for (Finding& finding : judgeMachine(machineFacts(), options)) findings.push_back(std::move(finding));
    judgeDevices(options, findings);
    std::vector<std::string> recipes;
    for (const SceneRecipe& recipe : sceneRecipes()) recipes.push_back(recipe.name);
    findings.push_back(judgeScene(options.scene, recipes));
    findings.push_back(judgeImageModule());
    findings.push_back(judgeAttempt("page", [&] {
        const std::string folder = clientFolder(options.client);
        return folder + ", " + std::to_string(readClientFiles(folder).size()) + " files";
    }));
    findings.push_back(judgeAttempt("access", [&] {
        const SocketOptions socket = socketOptions(options, handedOverSockets());
        return std::string(socket.token.empty() ? "no token is asked for" : "with a token") +
               (socket.certificateFile.empty() ? ", http" : ", https");
    }));
    for (const ListenAddress& address : handedOverSockets())
        findings.push_back({"socket", Finding::Kind::good, textOf(address), "the service manager's: " + address.name});
    for (const std::string& address : options.listen) findings.push_back(judgeAddress(address));
    return findings;
}

}  // namespace

void addDoctorCommand(CLI::App& app, std::function<int()>& run) {
    auto line = std::make_shared<ServeCommandLine>();
    auto json = std::make_shared<bool>(false);
    CLI::App* command =
        app.add_subcommand("doctor", "Tell what is here, and what serve with the same options would use and why");
    addServeFlags(*command, *line);
    command->add_flag("--json", *json, "Print JSON");
    command->footer("Exit code: 0 when serving would work, 1 when it would fail. ! marks why, ? what could be better.");
    command->callback([&run, line, json, command] {
        run = [line, json, command] {
            const std::vector<Finding> findings = examine(*line, *command);
            if (*json) std::cout << doctorJson(findings).dump(2) << "\n";
            else std::cout << doctorText(findings);
            return wouldServe(findings) ? 0 : 1;
        };
    });
}

}  // namespace heliograph

#include "server/operations/doctor.h"

#include "server/base/error.h"
#include "server/base/machine.h"
#include "server/base/text.h"
#include "server/net/listen/listener.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>

namespace heliograph {

namespace {

using FindingKind = Finding::Kind;

constexpr uint64_t SPARE_DESCRIPTORS = 256;      // libraries, scenes, drivers, connections that look at no picture
constexpr uint64_t LEAST_MEMORY = 512ull << 20;  // bytes; the courtyard with two viewers

std::string mebibytes(uint64_t bytes) { return std::to_string(bytes >> 20) + " MiB"; }

/// A line of /proc/meminfo, in bytes; 0 if it is not there.
uint64_t memoryLine(const std::string& key) {
    std::ifstream in("/proc/meminfo");
    for (std::string line; std::getline(in, line);) {
        std::istringstream fields(line);
        std::string name;
        uint64_t kilobytes = 0;
        if (fields >> name >> kilobytes && name == key + ":") return kilobytes * 1024;
    }
    return 0;
}

/// Limit of the control group (v2, else v1); 0 if there is none.
uint64_t controlGroupLimit() {
    for (const char* file : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
        std::ifstream in(file);
        uint64_t bytes = 0;
        // v1 says "no limit" as a number near 2^63, v2 as "max".
        if (in >> bytes) return bytes < (1ull << 62) ? bytes : 0;
    }
    return 0;
}

Finding judgeMemory(const MachineFacts& facts) {
    const bool limited = facts.memoryLimit > 0 && facts.memoryLimit < facts.memory;
    Finding memory{"memory", FindingKind::good,
                   mebibytes(facts.memory) + ", " + mebibytes(facts.memoryAvailable) + " available", ""};
    if (limited) {
        memory.found += ", limited to " + mebibytes(facts.memoryLimit) + " by the control group";
        memory.means = "the limit counts";
    }
    if ((limited ? facts.memoryLimit : facts.memory) < LEAST_MEMORY) {
        memory.kind = FindingKind::note;
        memory.means = "less than " + mebibytes(LEAST_MEMORY) + ": large scenes and pictures will not fit";
    }
    return memory;
}

Finding judgeDescriptors(const MachineFacts& facts, const ServeOptions& options) {
    const uint64_t needed = options.maxViewers + SPARE_DESCRIPTORS;
    Finding descriptors{"descriptors", FindingKind::good,
                        std::to_string(facts.descriptors) + ", at most " + std::to_string(facts.mostDescriptors),
                        "enough for " + std::to_string(options.maxViewers) + " viewers"};
    if (facts.descriptors < needed) {
        descriptors.kind = FindingKind::note;
        descriptors.means = std::to_string(options.maxViewers) + " viewers need up to " + std::to_string(needed) +
                            "; ulimit -n or LimitNOFILE= raises it";
    }
    return descriptors;
}

const char* word(FindingKind kind) { return kind == FindingKind::good ? "good" : kind == FindingKind::note ? "note" : "bad"; }

}  // namespace

MachineFacts machineFacts() {
    rlimit limit{};
    getrlimit(RLIMIT_NOFILE, &limit);
    MachineFacts facts;
    facts.processor = processorName();
    facts.cores = std::max(1l, sysconf(_SC_NPROCESSORS_ONLN));
    facts.usableCores = usableProcessors();
    facts.memory = memoryLine("MemTotal");
    facts.memoryAvailable = memoryLine("MemAvailable");
    facts.memoryLimit = controlGroupLimit();
    facts.descriptors = limit.rlim_cur;
    facts.mostDescriptors = limit.rlim_max;
    return facts;
}

std::vector<Finding> judgeMachine(const MachineFacts& facts, const ServeOptions& options) {
    Finding cores{"cores", FindingKind::good, std::to_string(facts.usableCores) + " of " + std::to_string(facts.cores),
                  "all are used"};
    if (facts.usableCores < facts.cores) cores.means = "affinity or the control group's quota (cpu.max) grants no more";
    return {{"processor", FindingKind::good, facts.processor, ""}, cores, judgeMemory(facts), judgeDescriptors(facts, options)};
}

Finding judgeAddress(const std::string& address) {
    const bool isPath = address.starts_with("unix:");
    return judgeAttempt(isPath ? "socket" : "port", [&]() -> std::string {
        const ListenAddress listen = parseListenAddress(address);
        const std::string problem = listenProblem(listen);
        if (!problem.empty())
            throw InputError(address, problem,
                             isPath ? "a path in a folder that this user may write to" : "a free port of this machine");
        if (isPath) return address + " can be made";
        return address + (listen.port == 0 ? " takes a free one" : " is free");
    });
}

/// The folder that a scene's file lies in. Throws InputError where it cannot be searched.
static std::string readableFolder(const std::string& file) {
    const std::filesystem::path path = std::filesystem::path(file).parent_path();
    const std::string folder = path.empty() ? "." : path.string();
    if (access(folder.c_str(), R_OK | X_OK) == 0) return folder;
    throw InputError(folder, "the scene's folder cannot be read: " + std::generic_category().message(errno),
                     "a folder that this user may list, for buffers and textures");
}

Finding judgeScene(const std::string& scene, const std::vector<std::string>& recipes) {
    return judgeAttempt("scene", [&]() -> std::string {
        if (std::ranges::find(recipes, scene) != recipes.end()) return scene + ", made by the program";
        std::error_code error;
        const auto status = std::filesystem::status(scene, error);
        if (std::filesystem::is_regular_file(status)) {
            std::ifstream file(scene);
            if (file) return scene + ", a file; what it names is read from " + readableFolder(scene);
            throw InputError(scene, "cannot be read: " + std::generic_category().message(errno), "a .gltf, .glb or .obj file");
        }
        throw InputError(scene, std::filesystem::exists(status) ? "is no file" : "is not there",
                         "a .gltf, .glb or .obj file, or a scene of the program");
    });
}

Finding judgeAttempt(const std::string& about, const std::function<std::string()>& work) {
    try {
        return {about, FindingKind::good, work(), ""};
    } catch (const std::exception& error) {
        return {about, FindingKind::bad, error.what(), ""};
    }
}

std::vector<Finding> judgeDeviceRows(const nlohmann::ordered_json& list, const std::vector<std::string>& words,
                                     const std::string& automatic) {
    std::vector<Finding> findings;
    for (const auto& row : list) {
        const std::string name = row["name"];
        Finding device{"device " + name, FindingKind::good, row.value("details", ""), ""};
        if (row.contains("type")) device.found += ", " + row.value("type", "") + ", " + row.value("driver", "");
        if (!row["refused"].is_null()) {
            device.kind = FindingKind::note;
            device.means = "not used: " + row.value("refused", "");
        } else if (name == automatic) {
            device.means = "used: what auto means";
        } else if (std::ranges::find(words, name) != words.end()) {
            device.means = row.value("type", "") == "cpu"
                               ? "used where it is asked for; it computes on the processor, where embree is faster"
                               : "used where it is asked for, and by hybrid";
        } else {
            device.means = "not used: not among the devices on offer";
        }
        findings.push_back(device);
    }
    return findings;
}

bool wouldServe(const std::vector<Finding>& findings) {
    return std::ranges::none_of(findings, [](const Finding& finding) { return finding.kind == FindingKind::bad; });
}

std::string doctorText(const std::vector<Finding>& findings) {
    constexpr size_t COLUMN = 16;
    std::string text;
    for (const Finding& finding : findings) {
        const char* mark = finding.kind == FindingKind::good ? "  " : finding.kind == FindingKind::note ? "? " : "! ";
        std::string about = oneLine(finding.about);
        about.resize(std::max(about.size() + 1, COLUMN), ' ');
        text += mark + about + oneLine(finding.found) + "\n";
        if (!finding.means.empty()) text += "  " + std::string(COLUMN, ' ') + oneLine(finding.means) + "\n";
    }
    return text +
           (wouldServe(findings) ? "heliograph serve would work.\n" : "heliograph serve would fail: see the lines with !\n");
}

nlohmann::ordered_json doctorJson(const std::vector<Finding>& findings) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Finding& f : findings)
        list.push_back({{"about", f.about}, {"state", word(f.kind)}, {"found", oneLine(f.found)}, {"means", oneLine(f.means)}});
    return {{"serves", wouldServe(findings)}, {"findings", list}};
}

}  // namespace heliograph

#pragma once
// What `heliograph doctor` looks at and how it judges: what is here, what would be used and why. What needs no device and no
// page is looked up here; the command adds those.

#include "server/operations/configuration.h"

#include <nlohmann/json.hpp>

#include <functional>

namespace heliograph {

/// One line of the report.
struct Finding {
    enum class Kind {
        good,
        note,  // serving works, but not as well as it could
        bad,   // serving would fail
    };
    std::string about;  // "port", "processor": the same word in JSON
    Kind kind = Kind::good;
    std::string found;
    std::string means;  // what is used and why, or what helps; may be empty
};

/// Numbers of the machine.
struct MachineFacts {
    std::string processor;
    uint32_t cores = 1, usableCores = 1;            // of the machine; of this process (affinity, control group)
    uint64_t memory = 0, memoryLimit = 0;           // bytes; of the machine, of the control group (0: none)
    uint64_t memoryAvailable = 0;                   // bytes, before anything has to be given up
    uint64_t descriptors = 0, mostDescriptors = 0;  // soft and hard limit
};
MachineFacts machineFacts();

/// Processor, memory, descriptors. Pure.
std::vector<Finding> judgeMachine(const MachineFacts& facts, const ServeOptions& options);
/// Each device of `heliograph devices --json`: what it is, and whether viewers may choose it. `words`: on offer; `automatic`:
/// what auto means. Pure.
std::vector<Finding> judgeDeviceRows(const nlohmann::ordered_json& list, const std::vector<std::string>& words,
                                     const std::string& automatic);
/// Whether the address can be listened on now; by trying.
Finding judgeAddress(const std::string& address);
/// Whether a start scene that is a file can be read.
Finding judgeScene(const std::string& scene, const std::vector<std::string>& recipes);
/// `work` done without InputError is good: what it returns is what was found.
Finding judgeAttempt(const std::string& about, const std::function<std::string()>& work);

bool wouldServe(const std::vector<Finding>& findings);
/// For people.
std::string doctorText(const std::vector<Finding>& findings);
/// {serves, findings: [{about, state: good|note|bad, found, means}]}
nlohmann::ordered_json doctorJson(const std::vector<Finding>& findings);

}  // namespace heliograph

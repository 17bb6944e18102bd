#pragma once
// All that an operator may say to `serve`: one row an option. The flag, the environment variable, the key of heliograph.toml,
// the help, the range and the reference page follow from the row.

#include "server/net/guard/limits.h"

#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace heliograph {

/// The options' values, as they are used.
struct ServeOptions {
    std::string scene = "courtyard";
    std::vector<std::string> listen = {"127.0.0.1:8080"};
    std::string socketMode = "0660";
    std::vector<std::string> devices;   // empty: all that are here
    std::string environment;            // file, or empty
    std::vector<std::string> settings;  // key=value, later ones win
    std::string tokenFile, adminTokenFile;
    bool insecure = false;
    std::string certificate, key;
    std::string client;
    std::string scenes;   // folder of scene files that are offered, or empty
    std::string uploads;  // folder for the files that viewers bring, or empty: they bring none
    uint64_t uploadMib = 256, uploadQuotaMib = 1024, uploadFiles = 1000, uploadSeconds = 600;
    uint64_t uploadsPerAddress = 2, uploadRateKib = 8;
    std::vector<std::string> origins;
    uint64_t maxViewers = MAX_VIEWERS;
    uint64_t maxGuests = MAX_GUESTS;
    uint64_t spareConnections = SPARE_CONNECTIONS;
    uint64_t spareConnectionsPerAddress = SPARE_PER_ADDRESS;
    uint64_t leastRate = 1;                                          // frames a second
    uint64_t mostSamples = 65536, mostRays = 256, mostBounces = 31;  // that viewers may set
    uint64_t filmMemoryMib = 0;                                      // 0: half of what the machine has
    uint64_t watchdogSeconds = 20;
    uint64_t keepViewSeconds = KEPT_VIEW.count();
    std::string pool;  // address of a broker, or empty: there is none
    std::string poolSecret, poolCa, poolCertificate, poolKey;
    bool poolInsecure = false;
    std::string logLevel = "info";
    bool logJson = false;
};

struct OptionRow {
    using Field = std::variant<std::string ServeOptions::*, bool ServeOptions::*, uint64_t ServeOptions::*,
                               std::vector<std::string> ServeOptions::*>;
    /// Throws InputError for a text that is not allowed.
    using Check = void (*)(const std::string& text);

    std::string_view name;  // "max-viewers": --max-viewers, HELIOGRAPH_MAX_VIEWERS, max-viewers = 32
    Field field;
    std::string_view type;  // what a value looks like, for help
    std::string_view help;
    bool reloadable = false;     // SIGHUP takes a new value; else it needs a restart
    uint64_t low = 0, high = 0;  // of numbers
    Check check = nullptr;       // of each text

    bool isFlag() const { return std::holds_alternative<bool ServeOptions::*>(field); }
    bool isList() const { return std::holds_alternative<std::vector<std::string> ServeOptions::*>(field); }
    bool isNumber() const { return std::holds_alternative<uint64_t ServeOptions::*>(field); }
};

/// All rows; "scene" and "set" among them.
std::span<const OptionRow> optionRows();
/// Null if there is none of that name.
const OptionRow* optionNamed(std::string_view name);
/// "max-viewers" -> "HELIOGRAPH_MAX_VIEWERS"
std::string environmentName(std::string_view option);
/// The name that `word` was probably meant to be, or an empty string.
std::string nearestOption(std::string_view word);

/// A value as it was found, before anything is known of it.
struct GivenValue {
    enum class Kind { word, text, number, boolean };  // `word`: of a command line or an environment, could be any
    std::string option;
    Kind kind = Kind::word;
    std::vector<std::string> texts;  // one, or a list's
    std::string source;              // "--max-viewers", "HELIOGRAPH_MAX_VIEWERS", "heliograph.toml:3: max-viewers"
};

/// Puts the value into its field; lists are replaced, but `set` gets its texts appended, so that each setting has its own
/// precedence. Throws InputError that names the source, what was found and what is allowed.
void apply(const GivenValue& given, ServeOptions& options);

/// The option's value as TOML.
std::string tomlValue(const OptionRow& row, const ServeOptions& options);
/// `text` in TOML's quotes.
std::string tomlText(std::string_view text);

}  // namespace heliograph

#pragma once
// The program's log: one line per event on stderr, so that stdout stays free for results. Uses spdlog's macros-free API:
// `log().info("listening on {}", address)`. Whatever a message holds, its line is one line of valid UTF-8 (oneLine).

#include <nlohmann/json.hpp>
#include <spdlog/logger.h>

#include <string>
#include <string_view>

namespace heliograph {

using LogLevel = spdlog::level::level_enum;

/// The process's logger, safe from all threads. Level `info` until setLogLevel.
spdlog::logger& log();
/// The same with fields for who reads JSON; `message` says all that a person needs.
void logWith(LogLevel level, std::string_view message, nlohmann::ordered_json fields);

/// trace, debug, info, warn, error or off. Throws InputError for another word.
void checkLogLevel(const std::string& level);
void setLogLevel(const std::string& level);
/// From now on each line is a JSON object: `time` (UTC, RFC 3339), `level`, `message`, `fields` where there are some.
void setLogJson(bool json);

}  // namespace heliograph

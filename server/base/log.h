#pragma once
// The program's log: one line per event on stderr, so that stdout stays free for results. Uses spdlog's macros-free API:
// `log().info("listening on {}", address)`.

#include <spdlog/logger.h>

#include <string>

namespace heliograph {

/// The process's logger, safe from all threads. Level `info` until setLogLevel.
spdlog::logger& log();
/// `level`: trace, debug, info, warn, error or off. Throws InputError for another word.
void setLogLevel(const std::string& level);

}  // namespace heliograph

#include "server/base/log.h"

#include "server/base/error.h"

#include <spdlog/sinks/stdout_color_sinks.h>

#include <memory>

namespace heliograph {

spdlog::logger& log() {
    static const std::shared_ptr<spdlog::logger> logger = [] {
        auto made = std::make_shared<spdlog::logger>("heliograph", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
        made->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
        made->flush_on(spdlog::level::info);
        return made;
    }();
    return *logger;
}

void setLogLevel(const std::string& level) {
    for (const char* known : {"trace", "debug", "info", "warn", "error", "off"}) {
        if (level != known) continue;
        log().set_level(spdlog::level::from_str(level));
        return;
    }
    throw InputError("log level", level, "trace, debug, info, warn, error or off");
}

}  // namespace heliograph

#include "server/base/log.h"

#include "server/base/error.h"
#include "server/base/text.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>

#include <ctime>
#include <memory>

namespace heliograph {

namespace {

using spdlog::memory_buf_t;
using spdlog::details::log_msg;

/// Of the message that this thread is just logging: the sink formats on the same thread.
thread_local nlohmann::ordered_json currentFields;

std::string_view viewOf(spdlog::string_view_t text) { return {text.data(), text.size()}; }

/// For people: date, time, level in colour, message.
class TextLines : public spdlog::formatter {
public:
    void format(const log_msg& message, memory_buf_t& out) override {
        const std::string line = oneLine(viewOf(message.payload));
        log_msg clean = message;
        clean.payload = line;
        pattern_.format(clean, out);
        // Where the colour begins and ends is told to the sink by fields of the message that it has.
        message.color_range_start = clean.color_range_start;
        message.color_range_end = clean.color_range_end;
    }
    std::unique_ptr<formatter> clone() const override { return std::make_unique<TextLines>(); }

private:
    spdlog::pattern_formatter pattern_{"%Y-%m-%d %H:%M:%S.%e %^%l%$ %v"};
};

/// For programs.
class JsonLines : public spdlog::formatter {
public:
    void format(const log_msg& message, memory_buf_t& out) override {
        using namespace std::chrono;
        const auto since = message.time.time_since_epoch();
        const std::time_t seconds = duration_cast<std::chrono::seconds>(since).count();
        std::tm utc{};
        gmtime_r(&seconds, &utc);
        char time[32], stamp[48];
        std::strftime(time, sizeof time, "%Y-%m-%dT%H:%M:%S", &utc);
        std::snprintf(stamp, sizeof stamp, "%s.%03dZ", time,
                      static_cast<int>(duration_cast<milliseconds>(since).count() % 1000));
        nlohmann::ordered_json line = {{"time", stamp},
                                       {"level", viewOf(spdlog::level::to_string_view(message.level))},
                                       {"message", oneLine(viewOf(message.payload))}};
        if (!currentFields.empty()) line["fields"] = currentFields;
        const std::string text = line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
        out.append(text.data(), text.data() + text.size());
    }
    std::unique_ptr<formatter> clone() const override { return std::make_unique<JsonLines>(); }
};

}  // namespace

spdlog::logger& log() {
    static const std::shared_ptr<spdlog::logger> logger = [] {
        auto made = std::make_shared<spdlog::logger>("heliograph", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
        made->set_formatter(std::make_unique<TextLines>());
        made->flush_on(spdlog::level::info);
        return made;
    }();
    return *logger;
}

void logWith(LogLevel level, std::string_view message, nlohmann::ordered_json fields) {
    if (!log().should_log(level)) return;
    currentFields = std::move(fields);
    log().log(level, spdlog::string_view_t(message.data(), message.size()));
    currentFields = nullptr;
}

void checkLogLevel(const std::string& level) {
    for (const char* known : {"trace", "debug", "info", "warn", "error", "off"}) {
        if (level == known) return;
    }
    throw InputError("log level", level, "trace, debug, info, warn, error or off");
}

void setLogLevel(const std::string& level) {
    checkLogLevel(level);
    log().set_level(spdlog::level::from_str(level));
}

void setLogJson(bool json) {
    if (json) log().set_formatter(std::make_unique<JsonLines>());
    else log().set_formatter(std::make_unique<TextLines>());
}

}  // namespace heliograph

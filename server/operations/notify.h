#pragma once
// What is said to the service manager that started the process, by systemd's protocol: datagrams of KEY=value lines to the
// socket that $NOTIFY_SOCKET names (sd_notify(3)). Without one nothing is said.

#include <chrono>
#include <cstdlib>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace heliograph {

/// Variables that were set, by name; as std::getenv.
using EnvironmentLookup = const char* (*)(const char* name);
inline const char* processVariable(const char* name) { return std::getenv(name); }

class ServiceManager {
public:
    explicit ServiceManager(EnvironmentLookup lookup = processVariable);

    /// Whether there is one.
    bool listens() const { return !path_.empty(); }
    /// How often it wants to hear alive(): half of $WATCHDOG_USEC, where that is meant for this process.
    std::optional<std::chrono::milliseconds> watchdogEvery() const { return watchdog_; }

    void ready(const std::string& status) const { say("READY=1\nSTATUS=" + line(status)); }
    void stopping() const { say("STOPPING=1\nSTATUS=ending"); }
    /// `ready` says that it is over.
    void reloading() const;
    /// What found the manager's queue full is said again before this.
    void alive() const;
    void status(const std::string& status) const { say("STATUS=" + line(status)); }

private:
    static std::string line(const std::string& text);
    void say(const std::string& state) const;
    void sayAgain() const;
    /// Whether the manager has it.
    bool sent(std::string_view state) const;

    std::string path_;  // begins with @ for a name that is no file
    std::optional<std::chrono::milliseconds> watchdog_;
    mutable std::mutex mutex_;
    mutable std::deque<std::string> unsaid_;  // states that found the queue full, the oldest first
};

}  // namespace heliograph

#include "server/operations/notify.h"

#include "server/base/log.h"
#include "server/base/text.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <ctime>
#include <system_error>

namespace heliograph {

namespace {

constexpr size_t MOST_UNSAID = 16;

/// Nothing for what is no number.
std::optional<uint64_t> numberOf(const char* text) {
    if (!text) return std::nullopt;
    uint64_t number = 0;
    const char* end = text + std::strlen(text);
    auto [stop, error] = std::from_chars(text, end, number);
    if (error != std::errc() || stop != end) return std::nullopt;
    return number;
}

}  // namespace

ServiceManager::ServiceManager(EnvironmentLookup lookup) {
    const char* path = lookup("NOTIFY_SOCKET");
    sockaddr_un address{};
    if (path && *path) {
        if ((*path == '/' || *path == '@') && std::strlen(path) < sizeof address.sun_path) path_ = path;
        else log().warn("NOTIFY_SOCKET: {}; allowed: a path or @name of at most {} bytes", path, sizeof address.sun_path - 1);
    }
    const std::optional<uint64_t> micros = numberOf(lookup("WATCHDOG_USEC"));
    const char* whose = lookup("WATCHDOG_PID");
    const bool ours = !whose || numberOf(whose) == static_cast<uint64_t>(getpid());
    if (listens() && ours && micros && *micros > 0)
        watchdog_ = std::chrono::milliseconds(std::clamp<uint64_t>(*micros / 2000, 1, 3'600'000));
}

std::string ServiceManager::line(const std::string& text) { return oneLine(text); }

void ServiceManager::reloading() const {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    const uint64_t micros = static_cast<uint64_t>(now.tv_sec) * 1'000'000 + static_cast<uint64_t>(now.tv_nsec) / 1000;
    say("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(micros));
}

void ServiceManager::say(const std::string& state) const {
    if (!listens()) return;
    std::lock_guard lock(mutex_);
    sayAgain();
    if (unsaid_.empty() && sent(state)) return;
    if (unsaid_.size() == MOST_UNSAID) unsaid_.pop_front();
    unsaid_.push_back(state);
}

void ServiceManager::alive() const {
    if (!listens()) return;
    std::lock_guard lock(mutex_);
    sayAgain();
    sent("WATCHDOG=1");
}

void ServiceManager::sayAgain() const {
    while (!unsaid_.empty() && sent(unsaid_.front())) unsaid_.pop_front();
}

bool ServiceManager::sent(std::string_view state) const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path_.data(), path_.size());
    socklen_t size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path_.size());
    if (path_.front() == '@') address.sun_path[0] = '\0';
    else size++;  // a path ends with its zero
    const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    // Never waits: a manager that does not read must not hold up the server.
    const bool taken = fd >= 0 && sendto(fd, state.data(), state.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
                                         reinterpret_cast<const sockaddr*>(&address), size) >= 0;
    if (!taken) log().warn("the service manager was not told ({}): {}", path_, std::generic_category().message(errno));
    if (fd >= 0) close(fd);
    return taken;
}

}  // namespace heliograph

#include "server/base/ports.h"

#include "server/base/text.h"

#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <system_error>

namespace heliograph {

namespace {

namespace fs = std::filesystem;

/// Inodes of the sockets that listen on the port, by a table such as /proc/net/tcp.
void listeners(const char* table, int port, std::set<std::string>& inodes) {
    constexpr const char* LISTENS = "0A";
    std::ifstream in(table);
    std::string line;
    std::getline(in, line);  // the heading
    while (std::getline(in, line)) {
        std::istringstream fields(line);
        std::string slot, local, remote, state, queues, timer, retransmits, user, timeout, inode;
        fields >> slot >> local >> remote >> state >> queues >> timer >> retransmits >> user >> timeout >> inode;
        const size_t colon = local.rfind(':');
        int found = -1;
        if (colon != std::string::npos) std::from_chars(local.data() + colon + 1, local.data() + local.size(), found, 16);
        if (state == LISTENS && found == port) inodes.insert("socket:[" + inode + "]");
    }
}

/// Whether the process of that folder of /proc has one of the sockets open.
bool holds(const fs::path& process, const std::set<std::string>& inodes) {
    std::error_code error;
    for (fs::directory_iterator fd(process / "fd", error), end; !error && fd != end; fd.increment(error)) {
        std::error_code unread;
        if (inodes.count(fs::read_symlink(fd->path(), unread).string()) != 0) return true;
    }
    return false;
}

}  // namespace

std::string portHolder(int port) {
    std::set<std::string> inodes;
    for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) listeners(table, port, inodes);
    if (inodes.empty()) return {};
    std::error_code error;
    for (fs::directory_iterator process("/proc", error), end; !error && process != end; process.increment(error)) {
        const std::string pid = process->path().filename().string();
        if (pid.find_first_not_of("0123456789") != std::string::npos || !holds(process->path(), inodes)) continue;
        std::string name;
        std::ifstream in(process->path() / "comm");
        std::getline(in, name);
        return "pid " + pid + " (" + oneLine(name) + ")";
    }
    return "another user's process";
}

int firstFreePort() {
    int first = 1024;
    std::ifstream("/proc/sys/net/ipv4/ip_unprivileged_port_start") >> first;
    return first;
}

std::string bindFailure(int error, int port) {
    std::string text = std::generic_category().message(error);
    if (error == EADDRINUSE) {
        const std::string holder = portHolder(port);
        if (!holder.empty()) text += ": " + holder + " listens there";
    }
    if (error == EACCES && port < firstFreePort())
        text += ": ports below " + std::to_string(firstFreePort()) + " are privileged (CAP_NET_BIND_SERVICE)";
    return text;
}

}  // namespace heliograph

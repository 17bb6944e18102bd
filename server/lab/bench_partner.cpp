#include "server/lab/bench_partner.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <istream>
#include <ostream>
#include <stdexcept>
#include <system_error>
#include <thread>

#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace heliograph {

namespace {

constexpr size_t LONGEST_LINE = 1 << 20;  // bytes

[[noreturn]] void fail(const std::string& program, const std::string& what) { throw std::runtime_error(program + ": " + what); }

}  // namespace

BenchPartner::BenchPartner(const std::string& program, const std::vector<std::string>& arguments) : program_(program) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) fail(program, std::generic_category().message(errno));
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    const int error = posix_spawn(&process_, program.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    line_ = ends[0];
    if (error != 0) {
        close(line_);
        fail(program, std::string("cannot be started: ") + std::generic_category().message(error));
    }
    try {
        greeting_ = line();
    } catch (...) {
        close(line_);
        kill(process_, SIGKILL);  // it may not read what it was told by the end of its input
        waitpid(process_, nullptr, 0);
        throw;
    }
}

BenchPartner::~BenchPartner() {
    using namespace std::chrono_literals;
    close(line_);  // its input ends, and so does it
    for (int i = 0; i < 100; i++) {
        if (waitpid(process_, nullptr, WNOHANG) != 0) return;
        std::this_thread::sleep_for(20ms);
    }
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
}

nlohmann::json BenchPartner::frame() {
    if (send(line_, "frame\n", 6, MSG_NOSIGNAL) != 6) fail(program_, "ended early");
    return line();
}

nlohmann::json BenchPartner::line() {
    size_t end;
    while ((end = unread_.find('\n')) == std::string::npos) {
        char bytes[4096];
        const ssize_t count = recv(line_, bytes, sizeof bytes, 0);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) fail(program_, "ended early");
        unread_.append(bytes, static_cast<size_t>(count));
        if (unread_.size() > LONGEST_LINE) fail(program_, "answers with something else than frames");
    }
    const std::string text = unread_.substr(0, end);
    unread_.erase(0, end + 1);
    nlohmann::json answer = nlohmann::json::parse(text, nullptr, false);
    if (!answer.is_object()) fail(program_, "answers with something else than frames");
    return answer;
}

void serveFrames(std::istream& in, std::ostream& out, const nlohmann::json& greeting,
                 const std::function<nlohmann::json()>& frame) {
    out << greeting.dump() << std::endl;
    for (std::string order; std::getline(in, order);) out << frame().dump() << std::endl;
}

std::string ownProgram() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

}  // namespace heliograph

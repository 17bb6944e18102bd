#include "server/operations/signals.h"

#include "server/base/log.h"

#include <poll.h>
#include <unistd.h>

#include <cstdlib>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

/// Whether the terminal at stdin was hung up.
bool terminalGone() {
    pollfd descriptor{STDIN_FILENO, 0, 0};
    return poll(&descriptor, 1, 0) > 0 && (descriptor.revents & (POLLHUP | POLLERR)) != 0;
}

[[noreturn]] void abandon(const char* why, int exitCode) {
    log().warn("{}", why);
    log().flush();
    std::_Exit(exitCode);
}

}  // namespace

Signals::Signals() : terminal_(isatty(STDIN_FILENO) != 0) {
    std::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to sockets that may be closed
    sigemptyset(&set_);
    for (int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) sigaddset(&set_, signal);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
}

Event Signals::wait(std::chrono::milliseconds atMost) const {
    const timespec time{atMost.count() / 1000, (atMost.count() % 1000) * 1'000'000};
    return eventOf(sigtimedwait(&set_, nullptr, &time));
}

Event Signals::eventOf(int signal) const {
    switch (signal) {
        case SIGINT:
        case SIGTERM: return Event::end;
        // A window that is closed means the end, not a new configuration.
        case SIGHUP: return terminal_ && terminalGone() ? Event::end : Event::reload;
        case SIGUSR1: return Event::sceneDone;
        default: return Event::none;
    }
}

void Signals::sceneDone() { kill(getpid(), SIGUSR1); }

ShutdownLimit::ShutdownLimit(const Signals& signals, std::chrono::milliseconds limit, int exitCode)
    : thread_([signals, limit, exitCode](std::stop_token stop) {
          const auto deadline = std::chrono::steady_clock::now() + limit;
          while (!stop.stop_requested()) {
              if (signals.wait(10ms) == Event::end) abandon("told twice: ended at once", exitCode);
              if (std::chrono::steady_clock::now() > deadline)
                  abandon("work in progress did not end in time and is abandoned", exitCode);
          }
      }) {}

}  // namespace heliograph

#include "server/base/background.h"

#include <sys/resource.h>
#include <unistd.h>

#include <exception>
#include <system_error>
#include <thread>

namespace heliograph {

void inBackground(const std::function<void()>& work) {
    std::exception_ptr thrown;
    auto quietly = [&] {
        try {
            work();
        } catch (...) {
            thrown = std::current_exception();
        }
    };
    try {
        // A thread of its own, since priority that was given up cannot be taken back without privileges.
        std::thread([&] {
            const auto self = static_cast<id_t>(gettid());
            setpriority(PRIO_PROCESS, self, getpriority(PRIO_PROCESS, self) + BACKGROUND_NICE);
            quietly();
        }).join();
    } catch (const std::system_error&) {
        quietly();
    }
    if (thrown) std::rethrow_exception(thrown);
}

}  // namespace heliograph

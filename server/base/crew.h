#pragma once
// Threads that help whoever calls with short work, many times a second. Unlike a task library's they never spin: who waits for
// the last helper sleeps, and the processor is free for other viewers' work. A helper that comes too late is not waited for.

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace heliograph {

/// Safe from several threads.
class Crew {
public:
    Crew() = default;
    ~Crew();
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;

    /// Calls `work` on this thread and on up to `helpers` others at once, and returns when all of those calls have. `work` shares
    /// what there is to do out among its calls. Throws what one of them threw. Where the system has no threads, fewer help.
    void run(size_t helpers, const std::function<void()>& work);

private:
    struct Job {
        const std::function<void()>& work;
        size_t wanted;  // helpers that may still come
        size_t inside = 0;
        std::exception_ptr error;
        std::condition_variable left;
    };
    void serve();
    void grow(size_t helpers);

    std::mutex mutex_;  // of all below and of jobs
    std::condition_variable called_;
    std::deque<Job*> jobs_;  // that want helpers
    bool over_ = false;
    std::vector<std::jthread> threads_;
};

}  // namespace heliograph

#pragma once
// Threads that wait for tasks. There are as many as were ever needed at once; a thread stuck in a driver
// doesn't block other tasks.

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace heliograph {

class WorkerPool {
public:
    /// Starts a detached thread; throws std::system_error when there is none to be had.
    using StartThread = std::function<void(std::function<void()>)>;
    static void startDetached(std::function<void()> body);

    explicit WorkerPool(StartThread startThread = startDetached);
    /// Waits for the tasks in progress, though not for ever: a thread that has not come back after some seconds is left to
    /// itself and to what its task holds.
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;

    /// Runs the task on a thread that has nothing else to do. Tasks must not throw. Throws std::system_error when a thread
    /// would be needed and the system has none; the task has not begun then.
    void run(std::function<void()> task);

private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
    const StartThread startThread_;
};

}  // namespace heliograph

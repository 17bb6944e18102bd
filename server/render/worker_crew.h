#pragma once
// Threads that wait for tasks. There are as many as were ever needed at once; one that a device keeps for ever costs
// nobody else his turn.

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace heliograph {

class WorkerCrew {
public:
    WorkerCrew();
    /// Waits for the tasks in progress, though not for ever: a thread that has not come back after some seconds is left to
    /// itself and to what its task holds.
    ~WorkerCrew();
    WorkerCrew(const WorkerCrew&) = delete;

    /// Runs the task on a thread that has nothing else to do. Tasks must not throw.
    void run(std::function<void()> task);

private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
};

}  // namespace heliograph

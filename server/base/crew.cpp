#include "server/base/crew.h"

#include <algorithm>
#include <system_error>

namespace heliograph {

Crew::~Crew() {
    {
        std::lock_guard lock(mutex_);
        over_ = true;
    }
    called_.notify_all();
}

/// With the lock held.
void Crew::grow(size_t helpers) {
    try {
        while (threads_.size() < helpers) threads_.emplace_back([this] { serve(); });
    } catch (const std::system_error&) {  // a limit of the machine or container
    }
}

void Crew::run(size_t helpers, const std::function<void()>& work) {
    Job job{work, helpers, 0, {}, {}};
    if (helpers > 0) {
        std::lock_guard lock(mutex_);
        grow(helpers);
        jobs_.push_back(&job);
    }
    for (size_t i = 0; i < helpers; i++) called_.notify_one();
    std::exception_ptr own;
    try {
        work();
    } catch (...) {
        own = std::current_exception();
    }
    std::unique_lock lock(mutex_);
    std::erase(jobs_, &job);
    job.left.wait(lock, [&] { return job.inside == 0; });
    if (own) std::rethrow_exception(own);
    if (job.error) std::rethrow_exception(job.error);
}

void Crew::serve() {
    std::unique_lock lock(mutex_);
    while (true) {
        called_.wait(lock, [&] { return over_ || !jobs_.empty(); });
        if (over_) return;
        Job& job = *jobs_.front();
        if (--job.wanted == 0) jobs_.pop_front();
        job.inside++;
        lock.unlock();
        std::exception_ptr error;
        try {
            job.work();
        } catch (...) {
            error = std::current_exception();
        }
        lock.lock();
        if (error) job.error = error;
        if (--job.inside == 0) job.left.notify_one();
    }
}

}  // namespace heliograph

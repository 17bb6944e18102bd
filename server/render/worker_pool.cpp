#include "server/render/worker_pool.h"

#include "server/base/log.h"

#include <chrono>
#include <thread>

namespace heliograph {

namespace {

constexpr auto PATIENCE = std::chrono::seconds(5);

}  // namespace

struct WorkerPool::Shared {
    struct Member {
        std::condition_variable called;
        std::function<void()> task;
    };
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<Member*> idle;  // the one that was busy last comes first: its caches are warm
    uint32_t alive = 0;
    bool over = false;

    void serve(std::function<void()> first) {
        Member self;
        self.task = std::move(first);
        std::unique_lock lock(mutex);
        for (;;) {
            self.called.wait(lock, [&] { return self.task || over; });
            if (!self.task) break;
            std::function<void()> task = std::move(self.task);
            self.task = nullptr;
            lock.unlock();
            task();
            task = nullptr;
            lock.lock();
            if (over) break;
            idle.push_back(&self);
            changed.notify_all();
        }
        alive--;
        changed.notify_all();
    }
};

void WorkerPool::startDetached(std::function<void()> body) { std::thread(std::move(body)).detach(); }

WorkerPool::WorkerPool(StartThread startThread) : shared_(std::make_shared<Shared>()), startThread_(std::move(startThread)) {}

WorkerPool::~WorkerPool() {
    std::unique_lock lock(shared_->mutex);
    shared_->over = true;
    for (Shared::Member* member : shared_->idle) member->called.notify_one();
    shared_->changed.wait_for(lock, PATIENCE, [&] { return shared_->alive == 0; });
    if (shared_->alive > 0) log().warn("{} threads are still inside a device and are left there", shared_->alive);
}

void WorkerPool::run(std::function<void()> task) {
    std::unique_lock lock(shared_->mutex);
    if (shared_->idle.empty()) {
        // The new thread waits for the lock: it is counted before it can end, and only if there is one.
        startThread_([shared = shared_, task = std::move(task)]() mutable { shared->serve(std::move(task)); });
        shared_->alive++;
        return;
    }
    Shared::Member* member = shared_->idle.back();
    shared_->idle.pop_back();
    member->task = std::move(task);
    lock.unlock();
    member->called.notify_one();
}

}  // namespace heliograph

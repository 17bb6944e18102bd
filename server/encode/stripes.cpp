#include "server/encode/stripes.h"

#include "server/base/clock.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <thread>

namespace heliograph {

double forEachStripe(uint32_t count, StripeThreads threads, const std::function<void(uint32_t)>& work) {
    if (threads == StripeThreads::own || count < 2) {
        for (uint32_t i = 0; i < count; i++) work(i);
        return 0.0;
    }
    std::atomic<double> others{0.0};
    const std::thread::id caller = std::this_thread::get_id();
    tbb::parallel_for(0u, count, [&](uint32_t i) {
        if (std::this_thread::get_id() == caller) return work(i);
        const double before = threadCpuSeconds();
        work(i);
        others.fetch_add(threadCpuSeconds() - before);
    });
    return others.load();
}

}  // namespace heliograph

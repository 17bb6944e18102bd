#include "server/schedule/schedule_report.h"

#include <algorithm>

namespace heliograph {

const char* DeviceReport::partWord() const {
    static constexpr const char* WORDS[] = {"works", "probes", "parked"};
    return lost ? "lost" : WORDS[static_cast<int>(part.part)];
}

double WorkerReport::busySeconds() const {
    double sum = 0.0;
    for (const Span& span : batches) sum += span.busy;
    return sum;
}

double ScheduleReport::endLoss() const {
    double last = begin, sum = 0.0;
    for (const WorkerReport& worker : workers) {
        const double finish = worker.batches.empty() ? begin : worker.batches.back().end;
        last = std::max(last, finish);
        sum += finish;
    }
    return workers.empty() ? 0.0 : last - sum / static_cast<double>(workers.size());
}

double ScheduleReport::idleShare(const WorkerReport& worker) const {
    if (!(seconds > 0.0)) return 0.0;
    return std::clamp(1.0 - worker.busySeconds() / seconds, 0.0, 1.0);
}

void ScheduleReport::append(const ScheduleReport& part) {
    if (devices.empty()) {
        *this = part;
        return;
    }
    std::vector<uint32_t> mapped;  // part's device numbers to ours
    for (const DeviceReport& device : part.devices) {
        auto same = std::find_if(devices.begin(), devices.end(), [&](const DeviceReport& d) { return d.name == device.name; });
        mapped.push_back(static_cast<uint32_t>(same - devices.begin()));
        if (same == devices.end()) {
            devices.push_back(device);
            continue;
        }
        const DeviceReport before = *same;
        *same = device;
        same->cost += before.cost;
        same->tiles += before.tiles;
        if (before.lost) {
            same->lost = true;
            same->part = before.part;
        }
    }
    for (const WorkerReport& worker : part.workers) {
        const uint32_t device = mapped[worker.device];
        auto same = std::find_if(workers.begin(), workers.end(),
                                 [&](const WorkerReport& w) { return w.device == device && w.stream == worker.stream; });
        if (same == workers.end()) {
            workers.push_back(worker);
            workers.back().device = device;
        } else {
            same->batches.insert(same->batches.end(), worker.batches.begin(), worker.batches.end());
        }
    }
    begin = std::min(begin, part.begin);
    end = std::max(end, part.end);
    seconds += part.seconds;
    decisionSeconds += part.decisionSeconds;
    batches += part.batches;
    reissued += part.reissued;
}

}  // namespace heliograph

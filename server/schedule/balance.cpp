#include "server/schedule/balance.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

namespace heliograph {

namespace {

/// How many mean errors are held back: a deviation of three mean absolute errors is rare (1.6 % if normal).
constexpr double ERRORS_HELD_BACK = 3.0;
/// Half, as factoring does when nothing is known of the spread.
constexpr double MOST_HELD_BACK = 0.5;
/// What is held back must be worth this many fixed costs.
constexpr double WORTH_A_BATCH = 2.0;

double overhead(const BalanceDevice& d) { return d.batchSeconds + d.roundTrip; }
double totalRate(const BalanceDevice& d) { return d.workers * d.rate; }
double alone(const BalanceDevice& d, double cost) { return overhead(d) + cost / totalRate(d); }

template <typename... Values>
std::string formatted(const char* format, Values... values) {
    char text[256];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

/// Of devices that share processors, only the fastest works.
void parkSharers(std::span<const BalanceDevice> devices, std::vector<DevicePart>& parts) {
    for (size_t i = 0; i < devices.size(); i++) {
        if (devices[i].forced || devices[i].hardware.empty()) continue;
        const BalanceDevice* best = nullptr;
        for (const BalanceDevice& other : devices) {
            if (other.hardware != devices[i].hardware) continue;
            if (best == nullptr || totalRate(other) > totalRate(*best)) best = &other;
        }
        if (best == &devices[i] || totalRate(devices[i]) <= 0.0) continue;
        parts[i] = {Part::parked, formatted("shares its processors with %s, which is %.1f times as fast on them",
                                            best->name.c_str(), totalRate(*best) / totalRate(devices[i]))};
    }
}

/// Devices of which nothing is known are measured, unless they would take processors away from one that is known, or that
/// stands before them in the list and is measured first.
void probeUnknown(std::span<const BalanceDevice> devices, std::vector<DevicePart>& parts) {
    for (size_t i = 0; i < devices.size(); i++) {
        if (totalRate(devices[i]) > 0.0 || parts[i].part == Part::parked) continue;
        parts[i] = {Part::probes, "not measured yet with these effects"};
        if (devices[i].forced || devices[i].hardware.empty()) continue;
        for (size_t j = 0; j < devices.size(); j++) {
            const BalanceDevice& other = devices[j];
            if (j == i || other.hardware != devices[i].hardware) continue;
            if (totalRate(other) > 0.0 || (j < i && parts[j].part != Part::parked)) {
                parts[i] = {Part::parked, "shares its processors with " + other.name + ", which goes first"};
            }
        }
    }
}

std::vector<BalanceDevice> working(std::span<const BalanceDevice> devices, const std::vector<DevicePart>& parts) {
    std::vector<BalanceDevice> chosen;
    for (size_t i = 0; i < devices.size(); i++) {
        if (parts[i].part == Part::works) chosen.push_back(devices[i]);
    }
    return chosen;
}

void parkTail(std::span<const BalanceDevice> devices, double cost, double end, std::vector<DevicePart>& parts) {
    std::vector<size_t> order;
    double strongest = 0.0;
    auto given = [&](size_t i) { return totalRate(devices[i]) * std::max(0.0, end - overhead(devices[i])); };
    for (size_t i = 0; i < devices.size(); i++) {
        if (parts[i].part != Part::works) continue;
        strongest = std::max(strongest, given(i));
        if (!devices[i].forced) order.push_back(i);
    }
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return given(a) < given(b); });
    double sum = 0.0;
    for (size_t i : order) {
        sum += given(i);
        if (sum >= LEAST_SHARE * cost || given(i) >= WEAK * strongest) return;
        parts[i] = {Part::parked, formatted("would make %.2f %% of the frame", 100.0 * given(i) / cost)};
    }
}

}  // namespace

double fractionalEnd(std::span<const BalanceDevice> devices, double cost) {
    // Devices join in the order of their overheads; between two of them the time falls as cost over the sum of rates.
    std::vector<const BalanceDevice*> order;
    for (const BalanceDevice& d : devices) {
        if (totalRate(d) > 0.0) order.push_back(&d);
    }
    std::sort(order.begin(), order.end(), [](auto* a, auto* b) { return overhead(*a) < overhead(*b); });
    double rates = 0.0, weighted = 0.0, end = std::numeric_limits<double>::infinity();
    for (const BalanceDevice* d : order) {
        if (overhead(*d) >= end) break;
        rates += totalRate(*d);
        weighted += totalRate(*d) * overhead(*d);
        end = (cost + weighted) / rates;
    }
    return end;
}

std::vector<DevicePart> chooseParts(std::span<const BalanceDevice> devices, double cost) {
    std::vector<DevicePart> parts(devices.size());
    parkSharers(devices, parts);
    probeUnknown(devices, parts);
    const std::vector<BalanceDevice> able = working(devices, parts);
    if (able.empty()) return parts;
    const double end = fractionalEnd(able, cost);
    size_t best = devices.size();
    for (size_t i = 0; i < devices.size(); i++) {
        if (parts[i].part != Part::works) continue;
        if (best == devices.size() || alone(devices[i], cost) < alone(devices[best], cost)) best = i;
    }
    const double gain = alone(devices[best], cost) / end - 1.0;
    for (size_t i = 0; i < devices.size(); i++) {
        if (parts[i].part != Part::works || devices[i].forced || i == best) continue;
        if (overhead(devices[i]) >= end) {
            parts[i] = {Part::parked, formatted("a batch takes %.2f ms beside the work, and the frame is done in %.2f ms",
                                                1e3 * overhead(devices[i]), 1e3 * end)};
        } else if (gain < LEAST_GAIN) {
            parts[i] = {Part::parked, formatted("all others together would gain %.1f %% over %s alone, under %.0f %%",
                                                100.0 * gain, devices[best].name.c_str(), 100.0 * LEAST_GAIN)};
        }
    }
    parkTail(devices, cost, end, parts);
    for (size_t i = 0; i < devices.size(); i++) {
        bool shares = parts[i].reason.starts_with("shares");
        if (parts[i].part == Part::parked && !shares && devices[i].age > REMEASURE_SECONDS) {
            parts[i] = {Part::probes, "parked, measured again: " + parts[i].reason};
        }
    }
    return parts;
}

BatchAnswer batchCost(const BatchQuestion& q) {
    if (!(q.room > 0.0) || !(q.rate > 0.0)) return {};
    // The device's own error grows with the batch, the cells' errors with the root of their number.
    const double cells = q.cellCost > 0.0 ? q.room * q.rate / q.cellCost : 0.0;
    const double error = std::max(q.spread * q.room, q.deviation * std::sqrt(cells) / q.rate);
    const double held = std::min(ERRORS_HELD_BACK * error, MOST_HELD_BACK * q.room);
    const bool last = held < WORTH_A_BATCH * q.batchSeconds || held * q.rate < q.cellCost;
    return {q.rate * (last ? q.room : q.room - held), last};
}

void cheapestLast(std::vector<uint32_t>& order, std::span<const float> costs, double share) {
    std::vector<uint32_t> dear(order);
    std::stable_sort(dear.begin(), dear.end(), [&](uint32_t a, uint32_t b) { return costs[a] > costs[b]; });
    double left = share * std::accumulate(costs.begin(), costs.end(), 0.0);
    size_t first = dear.size();
    while (first > 0 && left >= costs[dear[first - 1]]) left -= costs[dear[--first]];
    std::vector<uint8_t> cheap(costs.size(), 0);
    for (size_t i = first; i < dear.size(); i++) cheap[dear[i]] = 1;
    std::erase_if(order, [&](uint32_t cell) { return cheap[cell] != 0; });
    order.insert(order.end(), dear.begin() + static_cast<std::ptrdiff_t>(first), dear.end());
}

double costDeviation(std::span<const float> predicted, std::span<const float> actual) {
    double sum = 0.0;
    const size_t count = std::min(predicted.size(), actual.size());
    for (size_t i = 0; i < count; i++) {
        const double error = static_cast<double>(actual[i]) - predicted[i];
        sum += error * error;
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

double overdueAt(double due, double duration, double spread, double again) {
    return due + std::max(again, ERRORS_HELD_BACK * spread * duration);
}

}  // namespace heliograph

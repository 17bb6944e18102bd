#include "server/pace/line_meter.h"

#include <algorithm>
#include <cmath>

namespace heliograph {

namespace {

constexpr double WINDOW = 10.0;              // seconds
constexpr double AHEAD = 0.15;               // seconds of the line's rate
constexpr double QUEUES = 0.06;              // seconds
constexpr double LEAST_BYTES = 32 * 1024;    // under way, whatever the line
constexpr double SHORTEST_FRAME = 1.0 / 60;  // seconds
constexpr double SHORTEST_TRIP = 1e-3;       // seconds over which a rate is measured

}  // namespace

uint32_t framesForLine(double leastRoundTrip, double frameSeconds, uint32_t atMost) {
    const double held = std::ceil(leastRoundTrip / std::max(frameSeconds, SHORTEST_FRAME));
    const double more = 1.0 + std::floor(held / 4.0);
    return static_cast<uint32_t>(std::clamp(held + more, 2.0, static_cast<double>(std::max(atMost, 2u))));
}

double bytesForLine(double bytesPerSecond, double leastRoundTrip, bool queues) {
    return std::max(LEAST_BYTES, bytesPerSecond * ((queues ? 1.0 : 2.0) * leastRoundTrip + AHEAD));
}

void Extreme::add(double value, double now) {
    auto worse = [&](double other) { return least_ ? other >= value : other <= value; };
    while (!values_.empty() && worse(values_.back().second)) values_.pop_back();
    values_.emplace_back(now, value);
    while (values_.front().first < now - WINDOW) values_.pop_front();
}

void LineMeter::begin(uint32_t frameId, double now, bool moving) { flights_.push_back({frameId, now, moving}); }

void LineMeter::sent(uint32_t frameId, size_t bytes, double now) {
    const bool idle = std::ranges::none_of(flights_, [](const Flight& flight) { return flight.bytes > 0; });
    for (Flight& flight : flights_) {
        if (flight.frameId != frameId) continue;
        flight.sent = now;
        flight.bytes = bytes;
        flight.deliveredBytes = delivered_;
        flight.deliveredAt = idle ? now : deliveredAt_;
    }
}

std::optional<QueueDelay> LineMeter::landed(uint32_t frameId, double now, std::optional<double> shown) {
    const auto found = std::ranges::find(flights_, frameId, &Flight::frameId);
    if (found == flights_.end()) return std::nullopt;
    const Flight flight = *found;
    flights_.erase(found);
    if (flight.bytes == 0) return std::nullopt;
    const double trip = now - flight.sent;
    const double viewer = std::clamp(shown.value_or(0.0), 0.0, trip);
    delivered_ += static_cast<double>(flight.bytes);
    deliveredAt_ = now;
    rate_.add((delivered_ - flight.deliveredBytes) / std::max(now - flight.deliveredAt, SHORTEST_TRIP), now);
    trips_.add(trip - viewer, now);
    shown_.add(viewer, now);
    const double queued = std::max(0.0, trip - viewer - leastRoundTrip());
    queueing_ += 0.2 * (queued - queueing_);
    return QueueDelay{queued, viewer - shown_.value(), flight.moving};
}

void LineMeter::drop(uint32_t frameId) {
    std::erase_if(flights_, [&](const Flight& flight) { return flight.frameId == frameId; });
}

void LineMeter::pinged(double roundTrip, double now) { pings_.add(roundTrip, now); }

std::optional<double> LineMeter::oldest() const {
    return flights_.empty() ? std::nullopt : std::optional(flights_.front().begun);
}

double LineMeter::leastRoundTrip() const {
    if (!pings_.known() || !trips_.known()) return pings_.known() ? pings_.value() : trips_.value();
    return std::min(pings_.value(), trips_.value());
}

bool LineMeter::room(double frameSeconds, uint32_t atMost) const {
    if (flights_.empty()) return true;
    if (flights_.size() >= framesForLine(leastRoundTrip(), frameSeconds, atMost)) return false;
    double bytes = 0.0;
    for (const Flight& flight : flights_) bytes += static_cast<double>(flight.bytes);
    return !rate_.known() || bytes < bytesForLine(bytesPerSecond(), leastRoundTrip(), queueing_ > QUEUES);
}

}  // namespace heliograph

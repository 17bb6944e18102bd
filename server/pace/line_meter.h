#pragma once
// What acknowledgements tell of the way to a viewer, and how many pictures may be under way on it. Round trips count by the
// least of ten seconds, never by their mean: that one contains the queue which the pictures themselves make, and a window that
// follows it grows by itself. Pure: time comes from outside, in seconds.
//
// N. Cardwell, Y. Cheng, C. S. Gunn, S. H. Yeganeh, V. Jacobson, "BBR: Congestion-Based Congestion Control", 2016: least round
// trip and greatest rate of delivery over a window; how the rate of a delivery is measured.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

namespace heliograph {

/// Frames that may be under way, where one is made every `frameSeconds`: as many as the line holds, one more, and another one
/// for each four, so that a hitch of line or viewer does not stop a long line.
uint32_t framesForLine(double leastRoundTrip, double frameSeconds, uint32_t atMost);
/// Bytes that may be under way before another frame goes: what the line holds and what it carries in 150 ms, at least 32 KiB.
/// Where nothing queues, the rate that was measured may be that of the window, not of the line: then twice what the line holds,
/// so that the window grows.
double bytesForLine(double bytesPerSecond, double leastRoundTrip, bool queues);

/// The least (or greatest) value of the last ten seconds before the newest one.
class Extreme {
public:
    explicit Extreme(bool least) : least_(least) {}
    void add(double value, double now);
    bool known() const { return !values_.empty(); }
    double value() const { return values_.empty() ? 0.0 : values_.front().second; }

private:
    bool least_;
    std::deque<std::pair<double, double>> values_;  // time and value: later ones, each worse than all behind it
};

/// How long a picture took from the server to the eye and its acknowledgement back, beyond what is least.
struct QueueDelay {
    double line = 0.0;    // on the way
    double viewer = 0.0;  // from its arrival until it was seen
    bool moving = false;  // it was a picture of a moving view
    double total() const { return line + viewer; }
};

class LineMeter {
public:
    /// Room is made for a frame, which is encoded now. `moving`: of a moving view.
    void begin(uint32_t frameId, double now, bool moving = false);
    /// It was handed to the socket.
    void sent(uint32_t frameId, size_t bytes, double now);
    /// It was seen: `shown` seconds after it had come, where the viewer says so. Nothing for a frame that is not under way.
    std::optional<QueueDelay> landed(uint32_t frameId, double now, std::optional<double> shown);
    /// It will never be seen: it was replaced or could not be encoded.
    void drop(uint32_t frameId);
    void dropAll() { flights_.clear(); }
    /// A round trip of a message of no size, as the viewer measured it.
    void pinged(double roundTrip, double now);

    size_t underWay() const { return flights_.size(); }
    /// When the oldest of them was begun; nothing where none is under way.
    std::optional<double> oldest() const;
    /// Whether another frame may go, where one is made every `frameSeconds`.
    bool room(double frameSeconds, uint32_t atMost) const;

    double leastRoundTrip() const;
    /// The most that was delivered; 0 while nothing was.
    double bytesPerSecond() const { return rate_.value(); }

private:
    struct Flight {
        uint32_t frameId;
        double begun;
        bool moving;
        double sent = 0.0;
        size_t bytes = 0;           // 0: not sent yet
        double deliveredBytes = 0;  // of all frames, and when, as it was sent
        double deliveredAt = 0.0;
    };

    std::deque<Flight> flights_;
    double delivered_ = 0.0;  // bytes of all frames
    double deliveredAt_ = 0.0;
    double queueing_ = 0.0;  // seconds that frames queue on the line, smoothed
    Extreme pings_{true};
    Extreme trips_{true};  // of frames, without what the viewer took
    Extreme shown_{true};  // what the viewer took
    Extreme rate_{false};  // bytes a second
};

}  // namespace heliograph

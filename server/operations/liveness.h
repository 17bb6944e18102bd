#pragma once
// Which parts of the server still move. Each part says so from its own loop; who asks learns which have not for long.

#include <atomic>
#include <chrono>
#include <list>
#include <string>
#include <vector>

namespace heliograph {

class Liveness {
public:
    using Clock = std::chrono::steady_clock;

    /// One loop. `beat` is safe from all threads.
    class Part {
    public:
        explicit Part(std::string name) : name_(std::move(name)) {}
        void beat(Clock::time_point now = Clock::now()) { last_ = now.time_since_epoch().count(); }
        /// It does nothing for the time being and cannot be stuck.
        void rest() { last_ = RESTS; }
        const std::string& name() const { return name_; }
        bool stuck(Clock::time_point now, Clock::duration limit) const {
            const Clock::rep last = last_;
            return last != RESTS && now.time_since_epoch().count() - last > limit.count();
        }

    private:
        static constexpr Clock::rep RESTS = -1;
        const std::string name_;
        std::atomic<Clock::rep> last_{RESTS};
    };

    /// Not while others ask. The part lives as long as this; it rests until its first beat.
    Part& add(std::string name) { return parts_.emplace_back(std::move(name)); }
    /// Names of the parts whose last beat is longer ago than `limit`.
    std::vector<std::string> stuck(Clock::time_point now, Clock::duration limit) const {
        std::vector<std::string> names;
        for (const Part& part : parts_) {
            if (part.stuck(now, limit)) names.push_back(part.name());
        }
        return names;
    }

private:
    std::list<Part> parts_;
};

}  // namespace heliograph

#pragma once
// How messages of the pool travel: NATS between machines, a hub in one process for tests.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace heliograph {

/// Safe from all threads.
class Transport {
public:
    /// Called on a thread of the transport's, one message of a subscription after the other; must not throw.
    using Handler = std::function<void(std::span<const uint8_t> bytes)>;

    virtual ~Transport() = default;
    /// Hands the message over; nobody knows whether it arrives. False where it cannot go out now: too large, or no line.
    virtual bool publish(const std::string& subject, std::span<const uint8_t> bytes) = 0;
    /// Messages of that subject go to the handler for as long as what is returned lives; its end waits for a call in
    /// progress. Survives a line that breaks. Throws std::runtime_error.
    virtual std::shared_ptr<void> subscribe(const std::string& subject, Handler handler) = 0;
    /// As publish; and where nobody listens on the subject, `whenNobody` is called with the number, from any thread.
    virtual bool publishFor(uint32_t number, const std::string& subject, std::span<const uint8_t> bytes) = 0;
    /// To be set before the first publishFor; until the returned value ends, which waits for a call in progress.
    virtual std::shared_ptr<void> whenNobody(std::function<void(uint32_t number)> handler) = 0;
    /// Whether there is a line now.
    virtual bool connected() const = 0;
    /// Where the line leads, for people; without secrets.
    virtual std::string peer() const = 0;
};

/// The largest message: NATS' usual limit is 1 MiB.
constexpr size_t MOST_MESSAGE_BYTES = 1000 * 1000;

}  // namespace heliograph

#pragma once
// Makes bytes of finished frames, on a thread of its own so that the next pass renders meanwhile. It holds one frame at a
// time: whoever has the next one waits until `busy` is over.

#include "server/base/mailbox.h"
#include "server/stream/picture_maker.h"
#include "server/net/viewer_socket.h"

#include <atomic>
#include <functional>
#include <thread>

namespace heliograph {

/// A frame as it leaves, and what its making cost.
struct Published {
    OutgoingPicture picture;
    FrameHeader header;
    PassFigures figures;
    MakingCosts costs;
    uint32_t targetSamples = 0;
};

class Publisher {
public:
    struct Order {
        FinishedFrame frame;
        uint32_t frameId = 0;
        FrameCodec codec = FrameCodec::jpeg;
        uint32_t quality = 80;  // of the JPEG
    };
    /// Called from the publisher's thread, after which it is no longer busy. `published` or `failure` is set.
    using Done = std::function<void(uint32_t frameId, std::optional<Published> published, const std::string& failure)>;

    explicit Publisher(Done done);
    ~Publisher() { finish(); }

    bool busy() const { return busy_.load(std::memory_order_acquire); }
    /// Must not be called while busy.
    void publish(Order order);
    /// Ends after the frame in work and waits for that; what is published later is dropped.
    void finish();

private:
    void run();
    Published make(const Order& order);

    Done done_;
    PictureMaker maker_;
    Mailbox<Order> orders_;
    std::atomic<bool> busy_{false};
    std::jthread thread_;
};

}  // namespace heliograph

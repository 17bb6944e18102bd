#pragma once
// Makes bytes of finished frames, on a thread of its own so that the next pass renders meanwhile. The thread is there while
// frames come. It holds one frame at a time: whoever has the next one waits until `busy` is over.

#include "server/base/mailbox.h"
#include "server/base/resting_thread.h"
#include "server/base/stage_clock.h"
#include "server/viewer/picture_maker.h"

#include <atomic>
#include <functional>
#include <variant>

namespace heliograph {

class EncodeThread {
public:
    /// Called from this thread, after which it is no longer busy. `encoded` or `failure` is set.
    using Done = std::function<void(uint32_t frameId, std::optional<EncodedFrame> encoded, const std::string& failure)>;

    explicit EncodeThread(Done done);
    ~EncodeThread() { finish(); }

    bool busy() const { return busy_.load(std::memory_order_acquire); }
    /// What it is at. `viewer`: for whom.
    std::optional<RunningStage> stage(uint32_t viewer) const { return stages_.running(viewer); }
    /// `header`, `keep`, `shared`: as PictureMaker::make. Must not be called while busy.
    void encode(FinishedFrame frame, const FrameHeader& header, bool keep, std::shared_ptr<SharedPictures> shared);
    /// A part of a picture, as PictureMaker::makePart. Must not be called while busy.
    void encode(std::shared_ptr<const StillPicture> still, uint32_t firstRow, uint32_t rows, const FrameHeader& header);
    /// To be called now and then. False where a frame waits because the system has no thread for it.
    bool retry() { return thread_.retry(); }
    /// Whether its thread is there.
    bool awake() const { return thread_.awake(); }
    /// Ends after the frame in work and waits for that; what comes later is dropped.
    void finish();

private:
    struct Part {
        std::shared_ptr<const StillPicture> still;
        uint32_t firstRow, rows;
    };
    struct Job {
        std::variant<FinishedFrame, Part> what;
        FrameHeader header;
        bool keep = false;
        std::shared_ptr<SharedPictures> shared = {};
    };
    bool turn();
    void put(Job job);
    EncodedFrame made(const Job& job);
    void tell(uint32_t frameId, std::optional<EncodedFrame> encoded, const std::string& failure);

    Done encoded_;
    PictureMaker maker_;
    Mailbox<Job> jobs_;
    StageClock stages_;
    std::atomic<bool> busy_{false};
    RestingThread thread_;  // last: it uses all of the above
};

}  // namespace heliograph

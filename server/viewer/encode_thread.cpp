#include "server/viewer/encode_thread.h"

#include "server/base/background.h"
#include "server/base/log.h"

namespace heliograph {

namespace {

constexpr double PATIENCE_SECONDS = 1.0;

}  // namespace

EncodeThread::EncodeThread(Done done)
    : encoded_(std::move(done)), thread_([this] { return turn(); }, PATIENCE_SECONDS, [this] { maker_.rest(); }) {}

void EncodeThread::finish() {
    jobs_.close();
    thread_.finish();
}

void EncodeThread::put(Job job) {
    busy_.store(true, std::memory_order_release);
    jobs_.put(std::move(job));
    thread_.call();  // without a thread it waits for `retry`: whoever puts a frame holds locks, and can be told nothing here
}

void EncodeThread::encode(FinishedFrame frame, const FrameHeader& header, bool keep, std::shared_ptr<SharedPictures> shared) {
    put({std::move(frame), header, keep, std::move(shared)});
}

void EncodeThread::encode(std::shared_ptr<const StillPicture> still, uint32_t firstRow, uint32_t rows,
                          const FrameHeader& header) {
    put({Part{std::move(still), firstRow, rows}, header});
}

EncodedFrame EncodeThread::made(const Job& job) {
    const auto* part = std::get_if<Part>(&job.what);
    if (part) return maker_.makePart(*part->still, part->firstRow, part->rows, job.header);
    const auto& frame = std::get<FinishedFrame>(job.what);
    if (!frame.picture) return maker_.make(frame, job.header, job.keep, job.shared.get());
    // A saved picture of many pixels takes seconds, and its viewer has no frames meanwhile; the others have.
    EncodedFrame encoded;
    inBackground([&] { encoded = maker_.make(frame, job.header); });
    return encoded;
}

bool EncodeThread::turn() {
    std::optional<Job> job = jobs_.take();
    if (!job) return false;
    auto span = stages_.enter("encode");
    std::optional<EncodedFrame> encoded;
    std::string failure;
    try {
        encoded = made(*job);
    } catch (const std::exception& e) {
        failure = e.what();
    }
    const uint32_t frameId = job->header.frameId;
    job.reset();  // the film is free for the next pass
    busy_.store(false, std::memory_order_release);
    tell(frameId, std::move(encoded), failure);
    return true;
}

/// Without memory to hand the frame over it is lost, as if it could not have been encoded; the next one comes.
void EncodeThread::tell(uint32_t frameId, std::optional<EncodedFrame> encoded, const std::string& failure) {
    try {
        encoded_(frameId, std::move(encoded), failure);
    } catch (const std::exception& e) {
        try {
            encoded_(frameId, std::nullopt, e.what());
        } catch (const std::exception&) {
            log().error("a frame was lost: no memory");
        }
    }
}

}  // namespace heliograph

#include "server/uploads/upload_writer.h"

#include "server/base/error.h"
#include "server/base/log.h"

#include <utility>

namespace heliograph {

/// `upload` is the writer's thread's alone, and so is its end.
struct UploadWriter::Work {
    std::unique_ptr<Upload> upload;
    std::string waiting;   // bytes to be written
    size_t written = 0;    // of those that are being written
    bool all = false;      // nothing more comes
    bool givenUp = false;  // nobody waits for its end
    bool ordered = false;  // stands in `ready_`
    std::optional<UploadEnd> end;

    bool hasRoom() const { return waiting.size() + written < MOST_WAITING; }
};

namespace {

/// Writes `bytes`, and finishes where they are the last ones. Nothing while more is to come.
std::optional<UploadEnd> written(Upload& upload, std::string_view bytes, bool last) {
    try {
        upload.take(bytes);
        return last ? std::optional(UploadEnd{201, upload.finish()}) : std::nullopt;
    } catch (const InputError& error) {
        return UploadEnd{422, error.what()};
    } catch (const std::exception& error) {
        log().error("an upload was given up: {}", error.what());
        return UploadEnd{507, "the server could not keep the upload"};
    }
}

}  // namespace

UploadWriter::UploadWriter(std::function<void()> changed) : changed_(std::move(changed)), thread_([this] { run(); }) {}

UploadWriter::~UploadWriter() {
    {
        std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wanted_.notify_all();
    thread_.join();
}

std::unique_ptr<UploadWriter::Line> UploadWriter::add(std::unique_ptr<Upload> upload) {
    auto work = std::make_shared<Work>();
    work->upload = std::move(upload);
    return std::make_unique<Line>(*this, std::move(work));
}

/// With the lock held.
void UploadWriter::order(const std::shared_ptr<Work>& work) {
    if (!std::exchange(work->ordered, true)) ready_.push_back(work);
    wanted_.notify_one();
}

UploadWriter::Line::~Line() {
    std::lock_guard lock(writer_.mutex_);
    work_->givenUp = true;
    work_->waiting = {};
    writer_.order(work_);
}

bool UploadWriter::Line::push(std::string_view piece) {
    std::lock_guard lock(writer_.mutex_);
    if (work_->end) return true;  // refused: what comes is dropped
    work_->waiting += piece;
    writer_.order(work_);
    return work_->hasRoom();
}

void UploadWriter::Line::finish() {
    std::lock_guard lock(writer_.mutex_);
    work_->all = true;
    writer_.order(work_);
}

bool UploadWriter::Line::hasRoom() const {
    std::lock_guard lock(writer_.mutex_);
    return work_->hasRoom();
}

std::optional<UploadEnd> UploadWriter::Line::end() const {
    std::lock_guard lock(writer_.mutex_);
    return work_->end;
}

void UploadWriter::run() {
    std::unique_lock lock(mutex_);
    while (true) {
        wanted_.wait(lock, [&] { return stopping_ || !ready_.empty(); });
        if (ready_.empty()) return;
        const std::shared_ptr<Work> work = std::move(ready_.front());
        ready_.pop_front();
        work->ordered = false;
        const std::string bytes = std::exchange(work->waiting, {});
        const bool last = work->all, dropped = work->givenUp || work->end.has_value();
        work->written = bytes.size();
        lock.unlock();
        std::optional<UploadEnd> end;
        if (work->upload && !dropped) end = written(*work->upload, bytes, last);
        if (dropped || end) work->upload.reset();  // removes what is not finished
        lock.lock();
        const bool wasFull = !work->hasRoom();
        work->written = 0;
        const bool ended = end.has_value() && !work->end;
        if (ended) work->end = std::move(end);
        if (ended) work->waiting = {};
        if (!ended && !(wasFull && work->hasRoom())) continue;
        lock.unlock();
        changed_();
        lock.lock();
    }
}

}  // namespace heliograph

#pragma once
// Puts uploads on the disk, on a thread of its own: the thread that reads the sockets hands bytes over and never waits for a
// disk. What is handed over and not written yet is bounded; whoever hands over stops reading until there is room again.

#include "server/uploads/upload_store.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <thread>

namespace heliograph {

/// How an upload ended.
struct UploadEnd {
    unsigned status = 201;  // HTTP
    std::string said;       // 201: the name it is opened by; else why it was refused
};

class UploadWriter {
    struct Work;

public:
    static constexpr size_t MOST_WAITING = 1 << 20;  // bytes of one upload that wait to be written

    /// One upload on its way; used by one thread.
    class Line {
    public:
        Line(UploadWriter& writer, std::shared_ptr<Work> work) : writer_(writer), work_(std::move(work)) {}
        /// Gives up what is not finished: the writer removes it.
        ~Line();
        Line(const Line&) = delete;
        /// False: so much waits that nothing more is to be read until hasRoom().
        bool push(std::string_view piece);
        /// All has been pushed; end() will say what became of it.
        void finish();
        bool hasRoom() const;
        /// Nothing while it is under way. A refusal may come before all was pushed.
        std::optional<UploadEnd> end() const;

    private:
        UploadWriter& writer_;
        const std::shared_ptr<Work> work_;
    };

    /// `changed` is called on the writer's thread, without a lock held, when a line has room again or has ended.
    explicit UploadWriter(std::function<void()> changed);
    /// Ends after its lines. What was given up is removed before it returns.
    ~UploadWriter();

    std::unique_ptr<Line> add(std::unique_ptr<Upload> upload);

private:
    void run();
    void order(const std::shared_ptr<Work>& work);

    const std::function<void()> changed_;
    std::mutex mutex_;  // of all below, and of every Work's fields but its upload
    std::condition_variable wanted_;
    std::deque<std::shared_ptr<Work>> ready_;  // have something to be done; each once
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace heliograph

#pragma once
// Files that viewers bring: each upload is one stream of bytes, written into a folder of its own below the operator's, under
// limits of size, number and time. What does not arrive whole leaves nothing on the disk. An upload's name cannot be guessed:
// who knows it may open it.

#include "server/uploads/manifest.h"

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

namespace heliograph {

class UploadStore;

/// One upload while it comes. The stream: four bytes, the length of the manifest, little-endian; the manifest; the bytes of
/// all files in its order.
class Upload {
public:
    /// Removes what came, unless it was finished.
    ~Upload();
    /// The next bytes. Throws InputError for a manifest or stream that is refused, std::runtime_error where the disk fails.
    void take(std::string_view piece);
    /// The name under which it is opened: upload/ID/FILE. Throws InputError where bytes are missing.
    std::string finish();

private:
    friend class UploadStore;
    struct Output;
    Upload(UploadStore& store, std::string id, uint64_t bytes, std::string address);
    void begin(std::string_view manifest);
    void write(std::string_view& piece);
    void openNext();
    void close();

    UploadStore& store_;
    const std::string id_;
    const uint64_t bytes_;  // that were promised, and are held of the quota
    const std::string address_;
    uint64_t came_ = 0;
    std::string head_;  // length and manifest, until the manifest is there
    std::optional<UploadManifest> manifest_;
    size_t next_ = 0;       // file to be opened
    uint64_t missing_ = 0;  // bytes of the open one
    int file_ = -1;
    bool finished_ = false;
};

/// Safe from all threads; uploads are each one thread's, and end before the store.
class UploadStore {
public:
    using Clock = std::chrono::steady_clock;

    /// Removes what a server before left there: folders with names of uploads. Throws InputError where the folder is missing or
    /// cannot be written to.
    UploadStore(std::filesystem::path folder, UploadLimits limits);
    /// Removes all uploads.
    ~UploadStore();

    const UploadLimits& limits() const { return limits_; }
    /// `bytes`: of the whole stream. Where the quota does not suffice the oldest uploads that nobody has opened for an hour go;
    /// the next upload that is written removes their files. `address`: where it comes from; empty ones are not counted. Throws
    /// InputError for too many bytes, a full quota, with MOST_AT_ONCE under way, or limits().perAddress of this address.
    std::unique_ptr<Upload> begin(uint64_t bytes, Clock::time_point now = Clock::now(), const std::string& address = {});
    /// The file that the name of an upload means; nothing for a name that is none. Throws InputError where it has gone.
    std::optional<std::filesystem::path> fileOf(const std::string& name, Clock::time_point now = Clock::now());
    /// Removes what turned out to be no scene.
    void forget(const std::string& name);
    /// Bytes of the quota that nothing holds.
    uint64_t freeBytes() const;

    static constexpr size_t MOST_AT_ONCE = 4;

private:
    friend class Upload;
    struct Kept {
        std::string scene;  // path within its folder
        uint64_t bytes = 0;
        Clock::time_point used;
    };

    std::filesystem::path folderOf(const std::string& id) const { return folder_ / id; }
    void keep(const Upload& upload, std::string scene);
    void drop(const Upload& upload);
    void ended(const Upload& upload);
    void removeCondemned();
    void makeRoom(uint64_t bytes, Clock::time_point now);
    uint64_t heldBytes() const;

    const std::filesystem::path folder_;
    const UploadLimits limits_;
    mutable std::mutex mutex_;
    std::map<std::string, Kept> kept_;  // by id
    uint64_t coming_ = 0;               // bytes promised
    size_t underWay_ = 0;
    std::map<std::string, size_t> ofAddress_;  // under way
    std::vector<std::string> condemned_;       // whose files are to go
};

/// "upload/ID/FILE" is the name of an upload: nothing is said of whether there is one.
bool isUploadName(std::string_view name);

}  // namespace heliograph

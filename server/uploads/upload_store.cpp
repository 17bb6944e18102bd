#include "server/uploads/upload_store.h"

#include "server/base/error.h"
#include "server/net/guard/token.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace heliograph {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view PREFIX = "upload/";
constexpr size_t ID_DIGITS = 32;
constexpr size_t LENGTH_BYTES = 4;
constexpr auto IDLE_BEFORE_ROOM = std::chrono::hours(1);

bool isId(std::string_view text) {
    return text.size() == ID_DIGITS &&
           std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0 || (c >= 'a' && c <= 'f'); });
}

std::string mebibytes(uint64_t bytes) { return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB"; }

[[noreturn]] void diskFailed(const std::string& what) { throw std::runtime_error(what + ": " + std::strerror(errno)); }

}  // namespace

bool isUploadName(std::string_view name) {
    if (!name.starts_with(PREFIX)) return false;
    name.remove_prefix(PREFIX.size());
    return isId(name.substr(0, ID_DIGITS)) && name.size() > ID_DIGITS && name[ID_DIGITS] == '/';
}

Upload::Upload(UploadStore& store, std::string id, uint64_t bytes, std::string address)
    : store_(store), id_(std::move(id)), bytes_(bytes), address_(std::move(address)) {}

Upload::~Upload() {
    close();
    if (!finished_) store_.drop(*this);
}

void Upload::take(std::string_view piece) {
    came_ += piece.size();
    if (came_ > bytes_) throw InputError("upload", "more bytes than its Content-Length");
    while (!manifest_ && !piece.empty()) {
        size_t wanted = LENGTH_BYTES;
        if (head_.size() >= LENGTH_BYTES) {
            uint32_t length = 0;
            for (size_t i = 0; i < LENGTH_BYTES; i++) length |= static_cast<uint32_t>(static_cast<uint8_t>(head_[i])) << 8 * i;
            if (length > MANIFEST_BYTES)
                throw InputError("upload", "a list of files of " + std::to_string(length) + " bytes", "at most 512 KiB");
            wanted += length;
        }
        const size_t count = std::min(piece.size(), wanted - head_.size());
        head_ += piece.substr(0, count);
        piece.remove_prefix(count);
        if (head_.size() == wanted && wanted > LENGTH_BYTES) begin(std::string_view(head_).substr(LENGTH_BYTES));
        else if (count == 0) throw InputError("upload", "an empty list of files");
    }
    while (!piece.empty()) write(piece);
}

/// The manifest is there.
void Upload::begin(std::string_view manifest) {
    manifest_ = parseManifest(manifest, store_.limits());
    if (manifest_->bytes() + head_.size() != bytes_)
        throw InputError("upload", "files of " + std::to_string(manifest_->bytes()) + " bytes",
                         "as many as the Content-Length says");
    store_.removeCondemned();
    if (!fs::create_directory(store_.folderOf(id_))) throw std::runtime_error("there is such an upload already");
    fs::permissions(store_.folderOf(id_), fs::perms::owner_all);
    openNext();
}

void Upload::write(std::string_view& piece) {
    if (file_ < 0) throw InputError("upload", "more bytes than its files have");
    const size_t count = static_cast<size_t>(std::min<uint64_t>(piece.size(), missing_));
    for (size_t done = 0; done < count;) {
        const ssize_t written = ::write(file_, piece.data() + done, count - done);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) diskFailed("the upload cannot be written");
        done += static_cast<size_t>(written);
    }
    piece.remove_prefix(count);
    missing_ -= count;
    if (missing_ == 0) openNext();
}

/// The next file that has bytes; empty ones are made on the way.
void Upload::openNext() {
    close();
    while (next_ < manifest_->files.size()) {
        const UploadManifest::File& file = manifest_->files[next_++];
        const fs::path path = store_.folderOf(id_) / file.path;
        fs::create_directories(path.parent_path());
        file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (file_ < 0) diskFailed("a file of the upload cannot be made");
        missing_ = file.bytes;
        if (missing_ > 0) return;
        close();
    }
}

void Upload::close() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
}

std::string Upload::finish() {
    if (!manifest_ || file_ >= 0 || next_ < manifest_->files.size() || came_ != bytes_)
        throw InputError("upload", std::to_string(came_) + " of " + std::to_string(bytes_) + " bytes", "all of them");
    store_.keep(*this, manifest_->scene);
    finished_ = true;
    std::string name = fs::path(manifest_->scene).filename().string();
    return std::string(PREFIX) + id_ + "/" + name;
}

UploadStore::UploadStore(fs::path folder, UploadLimits limits) : folder_(std::move(folder)), limits_(limits) {
    std::error_code error;
    if (!fs::is_directory(folder_, error)) throw InputError("--uploads", folder_.string(), "a folder that is there");
    if (access(folder_.c_str(), R_OK | W_OK | X_OK) != 0)
        throw InputError("--uploads", folder_.string() + ": " + std::strerror(errno), "a folder that the server may write to");
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        if (isId(entry.path().filename().string()) && entry.is_directory() && !entry.is_symlink())
            fs::remove_all(entry.path(), error);
    }
}

UploadStore::~UploadStore() {
    std::error_code error;
    for (const auto& [id, upload] : kept_) fs::remove_all(folderOf(id), error);
    removeCondemned();
}

std::unique_ptr<Upload> UploadStore::begin(uint64_t bytes, Clock::time_point now, const std::string& address) {
    if (bytes > limits_.bytes + MANIFEST_BYTES)
        throw InputError("upload", mebibytes(bytes), "at most " + mebibytes(limits_.bytes));
    std::lock_guard lock(mutex_);
    if (underWay_ >= MOST_AT_ONCE)
        throw InputError("upload", std::to_string(underWay_) + " others are under way", "try again in a minute");
    const auto same = ofAddress_.find(address);
    if (same != ofAddress_.end() && same->second >= limits_.perAddress)
        throw InputError("upload", std::to_string(same->second) + " others of this address are under way",
                         "at most " + std::to_string(limits_.perAddress) + "; try again when one is through");
    makeRoom(bytes, now);
    std::unique_ptr<Upload> upload(new Upload(*this, randomSecret(), bytes, address));
    underWay_++;
    if (!address.empty()) ofAddress_[address]++;
    coming_ += bytes;
    return upload;
}

/// With the lock held.
void UploadStore::makeRoom(uint64_t bytes, Clock::time_point now) {
    while (heldBytes() + bytes > limits_.quota) {
        const auto oldest = std::ranges::min_element(kept_, {}, [](const auto& entry) { return entry.second.used; });
        if (oldest == kept_.end() || now - oldest->second.used < IDLE_BEFORE_ROOM)
            throw InputError("upload", "the server's room for uploads is full", "try again later, or a smaller one");
        condemned_.push_back(oldest->first);
        kept_.erase(oldest);
    }
}

void UploadStore::removeCondemned() {
    std::vector<std::string> ids;
    {
        std::lock_guard lock(mutex_);
        ids.swap(condemned_);
    }
    std::error_code error;
    for (const std::string& id : ids) fs::remove_all(folderOf(id), error);
}

std::optional<fs::path> UploadStore::fileOf(const std::string& name, Clock::time_point now) {
    if (!isUploadName(name)) return std::nullopt;
    const std::string id = name.substr(PREFIX.size(), ID_DIGITS);
    std::lock_guard lock(mutex_);
    const auto found = kept_.find(id);
    if (found == kept_.end()) throw InputError("scene.name", "an upload that is not here (any more)", "upload it again");
    found->second.used = now;
    return folderOf(id) / found->second.scene;
}

void UploadStore::forget(const std::string& name) {
    if (!isUploadName(name)) return;
    const std::string id = name.substr(PREFIX.size(), ID_DIGITS);
    {
        std::lock_guard lock(mutex_);
        if (kept_.erase(id) == 0) return;
    }
    std::error_code error;
    fs::remove_all(folderOf(id), error);
}

uint64_t UploadStore::freeBytes() const {
    std::lock_guard lock(mutex_);
    const uint64_t held = heldBytes();
    return held < limits_.quota ? limits_.quota - held : 0;
}

uint64_t UploadStore::heldBytes() const {
    uint64_t held = coming_;
    for (const auto& [id, upload] : kept_) held += upload.bytes;
    return held;
}

void UploadStore::keep(const Upload& upload, std::string scene) {
    std::lock_guard lock(mutex_);
    kept_[upload.id_] = {std::move(scene), upload.bytes_, Clock::now()};
    ended(upload);
}

void UploadStore::drop(const Upload& upload) {
    std::error_code error;
    fs::remove_all(folderOf(upload.id_), error);
    std::lock_guard lock(mutex_);
    ended(upload);
}

/// With the lock held.
void UploadStore::ended(const Upload& upload) {
    coming_ -= upload.bytes_;
    underWay_--;
    const auto same = ofAddress_.find(upload.address_);
    if (same != ofAddress_.end() && --same->second == 0) ofAddress_.erase(same);
}

}  // namespace heliograph

#include "server/pool/node/part_store.h"

#include "server/pool/wire/bytes.h"
#include "server/pool/scene_parts.h"

#include <algorithm>
#include <fstream>

namespace heliograph {

namespace fs = std::filesystem;

namespace {

bool readInto(std::ifstream& file, std::vector<uint8_t>& bytes) {
    return static_cast<bool>(file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
}

bool isSound(const PartList& list, std::span<const uint8_t> bytes) {
    for (size_t i = 0; i < list.parts.size(); i++) {
        const size_t begin = i * PART_BYTES;
        if (digestOf(bytes.subspan(begin, std::min(PART_BYTES, bytes.size() - begin))) != list.parts[i]) return false;
    }
    return true;
}

}  // namespace

std::optional<std::vector<uint8_t>> PartStore::find(const Digest& scene) const {
    if (folder_.empty()) return std::nullopt;
    std::ifstream file(pathOf(scene), std::ios::binary);
    uint64_t listBytes = 0;
    std::error_code error;
    const uint64_t size = fs::file_size(pathOf(scene), error);
    if (error || !file.read(reinterpret_cast<char*>(&listBytes), sizeof listBytes)) return std::nullopt;
    if (listBytes > size) return std::nullopt;
    try {
        std::vector<uint8_t> listText(static_cast<size_t>(listBytes));
        if (!readInto(file, listText)) return std::nullopt;
        const PartList list = readPartList(listText, scene);
        if (list.bytes > size) return std::nullopt;
        std::vector<uint8_t> bytes(static_cast<size_t>(list.bytes));
        if (!readInto(file, bytes) || !isSound(list, bytes)) return std::nullopt;
        fs::last_write_time(pathOf(scene), fs::file_time_type::clock::now(), error);  // used now
        return bytes;
    } catch (const PoolMessageError&) {
        return std::nullopt;
    }
}

void PartStore::keep(const Digest& scene, std::span<const uint8_t> list, std::span<const uint8_t> bytes,
                     std::string& why) const {
    if (folder_.empty() || bytes.size() > most_) return;
    std::error_code error;
    fs::create_directories(folder_, error);
    makeRoom(bytes.size());
    const fs::path path = pathOf(scene), part = path.string() + ".part";
    {
        std::ofstream file(part, std::ios::binary);
        const uint64_t listBytes = list.size();
        file.write(reinterpret_cast<const char*>(&listBytes), sizeof listBytes);
        file.write(reinterpret_cast<const char*>(list.data()), static_cast<std::streamsize>(list.size()));
        file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!file.flush()) why = part.string() + ": cannot be written";
    }
    if (why.empty()) fs::rename(part, path, error);
    if (error) why = path.string() + ": " + error.message();
    if (!why.empty()) fs::remove(part, error);
}

/// For one more file of that size.
void PartStore::makeRoom(uint64_t bytes) const {
    struct File {
        fs::file_time_type used;
        fs::path path;
        uint64_t bytes;
    };
    std::vector<File> files;
    std::error_code error;
    uint64_t sum = bytes;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_, error)) {
        if (entry.path().extension() != ".scene") continue;
        files.push_back({entry.last_write_time(error), entry.path(), entry.file_size(error)});
        sum += files.back().bytes;
    }
    std::ranges::sort(files, {}, &File::used);
    for (const File& file : files) {
        if (sum <= most_) return;
        sum -= file.bytes;
        fs::remove(file.path, error);
    }
}

}  // namespace heliograph

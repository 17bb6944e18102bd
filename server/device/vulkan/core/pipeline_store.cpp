#include "server/device/vulkan/core/pipeline_store.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include <unistd.h>

namespace heliograph {

namespace {

constexpr char MAGIC[8] = {'H', 'G', 'P', 'I', 'P', 'E', '1', '\n'};

struct Head {
    char magic[8];
    uint64_t bytes;
    uint64_t sum;
};

/// FNV-1a (Fowler, Noll, Vo) over words of 64 bits, the last one filled up with zeros.
uint64_t sumOf(std::span<const uint8_t> bytes) {
    uint64_t sum = 0xcbf29ce484222325u;
    for (size_t at = 0; at < bytes.size(); at += sizeof(uint64_t)) {
        uint64_t word = 0;
        std::memcpy(&word, bytes.data() + at, std::min(sizeof word, bytes.size() - at));
        sum = (sum ^ word) * 0x100000001b3u;
    }
    return sum;
}

}  // namespace

std::filesystem::path cacheFolder() {
    if (const char* own = std::getenv("HELIOGRAPH_CACHE")) return own;
    const char* caches = std::getenv("XDG_CACHE_HOME");
    if (caches && *caches == '/') return std::filesystem::path(caches) / "heliograph";
    const char* home = std::getenv("HOME");
    if (home && *home == '/') return std::filesystem::path(home) / ".cache/heliograph";
    return {};
}

std::vector<uint8_t> PipelineStore::read() const {
    std::ifstream file(file_, std::ios::binary);
    Head head{};
    if (!file.read(reinterpret_cast<char*>(&head), sizeof head) || std::memcmp(head.magic, MAGIC, sizeof MAGIC) != 0 ||
        head.bytes > MOST_BYTES)
        return {};
    std::error_code error;
    if (std::filesystem::file_size(file_, error) != sizeof head + head.bytes || error) return {};
    std::vector<uint8_t> bytes(head.bytes);
    if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) return {};
    return sumOf(bytes) == head.sum ? bytes : std::vector<uint8_t>{};
}

bool PipelineStore::keep(std::span<const uint8_t> bytes) const {
    if (file_.empty() || bytes.size() > MOST_BYTES) return false;
    Head head{{}, bytes.size(), sumOf(bytes)};
    std::memcpy(head.magic, MAGIC, sizeof MAGIC);
    std::error_code error;
    std::filesystem::create_directories(file_.parent_path(), error);
    std::filesystem::path made = file_;
    made += "." + std::to_string(getpid());
    {
        std::ofstream file(made, std::ios::binary | std::ios::trunc);
        file.write(reinterpret_cast<const char*>(&head), sizeof head);
        file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        file.close();
        if (!file) {
            std::filesystem::remove(made, error);
            return false;
        }
    }
    std::filesystem::rename(made, file_, error);
    if (error) std::filesystem::remove(made, error);
    return !error;
}

}  // namespace heliograph

#pragma once
// Bytes of compiled programs that outlive the process: in a file for each kind of device. What is damaged counts as absent, and
// what cannot be written is given up: a store saves time and nothing else.

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace heliograph {

/// $HELIOGRAPH_CACHE, else $XDG_CACHE_HOME/heliograph, else $HOME/.cache/heliograph. Empty where the first one is set and
/// empty, or none of them is set: nothing is kept then.
std::filesystem::path cacheFolder();

class PipelineStore {
public:
    static constexpr uint64_t MOST_BYTES = 64ull << 20;  // of a file; some hundred programs

    /// `file`: empty keeps nothing.
    explicit PipelineStore(std::filesystem::path file) : file_(std::move(file)) {}

    bool keeps() const { return !file_.empty(); }
    const std::filesystem::path& file() const { return file_; }
    /// What was kept last, by whatever process; nothing where there is none, or where it is damaged.
    std::vector<uint8_t> read() const;
    /// Replaces it as a whole: readers see the one or the other. False if it cannot be written; the old one then stays.
    bool keep(std::span<const uint8_t> bytes) const;

private:
    const std::filesystem::path file_;
};

}  // namespace heliograph

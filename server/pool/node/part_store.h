#pragma once
// A node's folder of scenes that it has been given: it need not be given them again.

#include "server/pool/wire/digest.h"

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace heliograph {

class PartStore {
public:
    /// An empty path keeps nothing. `most`: bytes of all files together; the ones that were used longest ago go.
    PartStore(std::filesystem::path folder, uint64_t most) : folder_(std::move(folder)), most_(most) {}

    /// The scene's bytes, checked part by part. Nothing where there are none, or they are not right.
    std::optional<std::vector<uint8_t>> find(const Digest& scene) const;
    /// Keeps them. What fails costs only the next fetch; `why` says so.
    void keep(const Digest& scene, std::span<const uint8_t> list, std::span<const uint8_t> bytes, std::string& why) const;

private:
    std::filesystem::path pathOf(const Digest& scene) const { return folder_ / (hexOf(scene) + ".scene"); }
    void makeRoom(uint64_t bytes) const;

    const std::filesystem::path folder_;
    const uint64_t most_;
};

}  // namespace heliograph

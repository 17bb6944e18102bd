#pragma once
// Uploads as the page sends them, for tests.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <stdlib.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace heliograph::test {

using Files = std::vector<std::pair<std::string, std::string>>;  // path and bytes

inline std::string manifestOf(const Files& files, const std::string& scene) {
    nlohmann::json list = {{"scene", scene}, {"files", nlohmann::json::array()}};
    for (const auto& [path, bytes] : files) list["files"].push_back({{"path", path}, {"bytes", bytes.size()}});
    return list.dump();
}

/// The length of the manifest, the manifest, the files.
inline std::string uploadStream(const std::string& manifest, const Files& files = {}) {
    std::string stream;
    for (int i = 0; i < 4; i++) stream += static_cast<char>(manifest.size() >> 8 * i & 255u);
    stream += manifest;
    for (const auto& [path, bytes] : files) stream += bytes;
    return stream;
}

inline std::string uploadStream(const Files& files, const std::string& scene) {
    return uploadStream(manifestOf(files, scene), files);
}

/// A folder of the test's own, gone afterwards.
class UploadFolder {
public:
    UploadFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "heliograph-uploads-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no folder for the test");
        path = name;
    }
    ~UploadFolder() { std::filesystem::remove_all(path); }
    /// Everything in it, by path, sorted. The server may remove a folder during the walk; then the walk begins again.
    std::vector<std::string> content() const {
        std::vector<std::string> names;
        std::error_code gone;
        std::filesystem::recursive_directory_iterator entry(path, gone);
        for (; !gone && entry != std::filesystem::recursive_directory_iterator(); entry.increment(gone))
            names.push_back(entry->path().lexically_relative(path).string());
        if (gone == std::errc::no_such_file_or_directory && std::filesystem::exists(path)) return content();
        if (gone) throw std::filesystem::filesystem_error("the folder cannot be read", path, gone);
        std::sort(names.begin(), names.end());
        return names;
    }

    std::filesystem::path path;
};

}  // namespace heliograph::test

#pragma once
// Scene files made by the tests: a scratch folder, glTF text with embedded data, GLB containers.

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace heliograph::testing_files {

namespace fs = std::filesystem;

/// A folder that vanishes with its owner.
class ScratchFolder {
public:
    ScratchFolder() {
        std::random_device random;
        path_ = fs::temp_directory_path() / ("heliograph-test-" + std::to_string(random()) + std::to_string(random()));
        fs::create_directories(path_);
    }
    ~ScratchFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::string write(const std::string& name, std::string_view content) const {
        const fs::path path = path_ / name;
        fs::create_directories(path.parent_path());
        std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
        return path.string();
    }
    const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

inline std::string base64(std::string_view bytes) {
    static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t word = 0;
        const size_t count = std::min<size_t>(3, bytes.size() - i);
        for (size_t k = 0; k < 3; k++) word = word << 8 | (k < count ? static_cast<uint8_t>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; k++) text.push_back(k <= count ? digits[word >> (18 - 6 * k) & 63] : '=');
    }
    return text;
}

template <typename T>
std::string bytesOf(std::initializer_list<T> values) {
    std::string bytes(values.size() * sizeof(T), '\0');
    std::memcpy(bytes.data(), values.begin(), bytes.size());
    return bytes;
}

inline std::string dataUri(const std::string& bytes) { return "data:application/octet-stream;base64," + base64(bytes); }

/// A GLB of version 2; parts are padded to 4 bytes.
inline std::string glb(std::string json, std::string binary) {
    while (json.size() % 4) json.push_back(' ');
    while (binary.size() % 4) binary.push_back('\0');
    const auto word = [](size_t value) { return bytesOf({static_cast<uint32_t>(value)}); };
    const size_t length = 12 + 8 + json.size() + (binary.empty() ? 0 : 8 + binary.size());
    std::string file = "glTF" + word(2) + word(length) + word(json.size()) + "JSON" + json;
    if (!binary.empty()) file += word(binary.size()) + std::string("BIN\0", 4) + binary;
    return file;
}

/// A triangle (0,0,0) (1,0,0) (0,1,0): JSON of a whole glTF around the buffer's uri property, or none. `extra`: more
/// root properties, with a leading comma.
inline std::string triangleJson(const std::string& uri, const std::string& extra = {}) {
    const std::string uriProperty = uri.empty() ? "" : R"("uri":")" + uri + R"(",)";
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],)"
           R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{)" +
           uriProperty + R"("byteLength":36}])" + extra + "}";
}

inline std::string triangleBytes() { return bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}); }

}  // namespace heliograph::testing_files

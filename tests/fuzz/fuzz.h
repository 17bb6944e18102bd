#pragma once
// What the fuzz targets share. Each target is libFuzzer's entry point: it may throw InputError and nothing else.

#include "server/base/error.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <unistd.h>

namespace heliograph::fuzz {

/// A folder of this process's own, in memory where the machine has such a place; gone when the process ends well.
inline const std::filesystem::path& scratch() {
    struct Folder {
        std::filesystem::path path;
        Folder() {
            const std::filesystem::path base =
                std::filesystem::exists("/dev/shm") ? "/dev/shm" : std::filesystem::temp_directory_path();
            path = base / ("heliograph-fuzz-" + std::to_string(getpid()));
            std::filesystem::create_directories(path);
        }
        ~Folder() {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    };
    static const Folder folder;
    return folder.path;
}

/// The bytes as a file of this name in scratch().
inline std::filesystem::path asFile(std::span<const uint8_t> bytes, const std::string& name) {
    const std::filesystem::path path = scratch() / name;
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return path;
}

/// Runs `body`; bad input is what it is made for.
template <class Body>
int refusing(Body body) {
    try {
        body();
    } catch (const InputError&) {}
    return 0;
}

}  // namespace heliograph::fuzz

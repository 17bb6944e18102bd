#pragma once
// A result file: checked before the work begins, written in one go after it.

#include <cstdint>
#include <span>
#include <string>

namespace heliograph {

class OutputFile {
public:
    /// Throws InputError, naming `option`, if a file of that name cannot be written: its folder is missing or read-only, or
    /// the name is a folder's. Nothing is created yet.
    OutputFile(const std::string& option, const std::string& path);

    const std::string& path() const { return path_; }
    /// Lower-case letters after the last dot of the name, or "".
    std::string extension() const;
    /// Replaces the file; whoever opens it sees the old one or the whole new one. Throws std::runtime_error.
    void write(std::span<const uint8_t> bytes) const;

private:
    std::string path_;
    bool direct_ = false;  // not a regular file (/dev/stdout, a pipe): written in place
};

}  // namespace heliograph

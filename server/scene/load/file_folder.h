#pragma once
// Reading of files that other files name. Private to server/scene.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace heliograph {

/// The largest file that is read whole, bytes.
constexpr uint64_t MOST_FILE_BYTES = uint64_t(2) << 30;

/// The bytes of a regular file. Throws InputError if it is missing, unreadable, no regular file or too large.
std::vector<uint8_t> readFile(const std::filesystem::path& path, uint64_t mostBytes = MOST_FILE_BYTES);

/// Undoes %XX. Throws InputError naming `where` for a broken escape.
std::string percentDecoded(std::string_view text, const std::string& where);

/// Equal but for the case of ASCII letters.
bool sameButForCase(std::string_view a, std::string_view b);

/// Without blanks and ends of lines, which some programs put between the letters of base64.
std::string withoutBlanks(std::string text);

/// Undoes base64; false for a character or length that is not base64.
bool decodeBase64(std::string_view text, std::vector<uint8_t>& bytes);

/// The folder of a scene file. What the file names must lie inside it, also after symbolic links are followed.
class FileFolder {
public:
    explicit FileFolder(const std::filesystem::path& sceneFile);

    /// Path of the file that a relative reference means ('/' separates); where there is none, of one whose name differs in the
    /// case of letters. Throws InputError naming `where` for an
    /// absolute path, a scheme, "..", a NUL, a missing file, or a file that lies outside after all.
    std::filesystem::path resolve(const std::string& reference, const std::string& where) const;

private:
    std::filesystem::path folder_;  // canonical
};

}  // namespace heliograph

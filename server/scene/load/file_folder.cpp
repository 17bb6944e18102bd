#include "server/scene/load/file_folder.h"

#include "server/base/error.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

namespace heliograph {

namespace fs = std::filesystem;

namespace {

int hexDigit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::array<int8_t, 256> base64Table() {
    std::array<int8_t, 256> table;
    table.fill(-1);
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (int i = 0; i < 64; i++) table[static_cast<unsigned char>(digits[i])] = static_cast<int8_t>(i);
    return table;
}

/// For messages: one line, not too long.
std::string shown(const std::string& text) { return "'" + text.substr(0, 120) + (text.size() > 120 ? "..." : "") + "'"; }

bool isInside(const fs::path& path, const fs::path& folder) {
    return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/// What `relative` means where names are the same whatever the case of their ASCII letters, as on Windows: the first in the
/// order of names. Empty where there is none, or a folder on the way holds more than MOST_LOOKED_AT.
fs::path withoutCase(const fs::path& folder, const fs::path& relative) {
    constexpr size_t MOST_LOOKED_AT = 4096;
    fs::path at = folder;
    for (const fs::path& part : relative) {
        std::error_code error;
        if (fs::exists(at / part, error)) {
            at /= part;
            continue;
        }
        std::string best;
        size_t looked = 0;
        for (fs::directory_iterator entry(at, error), end; !error && entry != end; entry.increment(error)) {
            if (++looked > MOST_LOOKED_AT) return {};
            const std::string name = entry->path().filename().string();
            if (sameButForCase(name, part.string()) && (best.empty() || name < best)) best = name;
        }
        if (best.empty()) return {};
        at /= best;
    }
    return at;
}

}  // namespace

std::vector<uint8_t> readFile(const fs::path& path, uint64_t mostBytes) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (status.type() == fs::file_type::not_found) throw InputError(path.string(), "the file does not exist");
    if (error) throw InputError(path.string(), error.message());
    if (status.type() != fs::file_type::regular) throw InputError(path.string(), "this is no regular file");
    const uint64_t size = fs::file_size(path, error);
    if (error) throw InputError(path.string(), error.message());
    if (size > mostBytes) {
        throw InputError(path.string(), std::to_string(size) + " bytes", "at most " + std::to_string(mostBytes));
    }
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file) throw InputError(path.string(), "the file cannot be opened");
    std::vector<uint8_t> bytes(size);
    if (std::fread(bytes.data(), 1, size, file.get()) != size) throw InputError(path.string(), "the file cannot be read");
    return bytes;
}

std::string percentDecoded(std::string_view text, const std::string& where) {
    std::string decoded;
    for (size_t i = 0; i < text.size(); i++) {
        char c = text[i];
        if (c == '%') {
            const int high = i + 2 < text.size() ? hexDigit(text[i + 1]) : -1;
            const int low = i + 2 < text.size() ? hexDigit(text[i + 2]) : -1;
            if (high < 0 || low < 0)
                throw InputError(where, "broken escape in " + shown(std::string(text.substr(0, 200))),
                                 "% and two hexadecimal digits");
            c = static_cast<char>(high * 16 + low);
            i += 2;
        }
        decoded.push_back(c);
    }
    return decoded;
}

bool sameButForCase(std::string_view a, std::string_view b) {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
    return std::ranges::equal(a, b, {}, lower, lower);
}

std::string withoutBlanks(std::string text) {
    std::erase_if(text, [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; });
    return text;
}

bool decodeBase64(std::string_view text, std::vector<uint8_t>& bytes) {
    static const std::array<int8_t, 256> table = base64Table();
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    if (text.size() % 4 == 1) return false;
    bytes.clear();
    bytes.reserve(text.size() * 3 / 4);
    uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int digit = table[static_cast<unsigned char>(c)];
        if (digit < 0) return false;
        bits = bits << 6 | static_cast<uint32_t>(digit);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<uint8_t>(bits >> count));
    }
    return true;
}

FileFolder::FileFolder(const fs::path& sceneFile) {
    std::error_code error;
    const fs::path parent = sceneFile.has_parent_path() ? sceneFile.parent_path() : fs::path(".");
    folder_ = fs::canonical(parent, error);
    if (error) throw InputError(parent.string(), error.message());
}

fs::path FileFolder::resolve(const std::string& reference, const std::string& where) const {
    const std::string allowed = "a relative path inside the scene file's folder";
    if (reference.empty() || reference.find('\0') != std::string::npos)
        throw InputError(where, "an empty path or one with a NUL character", allowed);
    const fs::path relative(reference);
    const bool hasScheme = reference.substr(0, reference.find('/')).find(':') != std::string::npos;
    const bool climbs = std::find(relative.begin(), relative.end(), fs::path("..")) != relative.end();
    if (relative.is_absolute() || hasScheme || climbs || reference.find('\\') != std::string::npos)
        throw InputError(where, shown(reference), allowed);
    std::error_code error;
    fs::path path = fs::canonical(folder_ / relative, error);
    if (error) {
        const fs::path other = withoutCase(folder_, relative);
        if (!other.empty()) path = fs::canonical(other, error);
    }
    if (error) throw InputError(where, shown(reference) + " does not exist");
    if (!isInside(path, folder_)) throw InputError(where, shown(reference) + " leads out of the folder", allowed);
    return path;
}

}  // namespace heliograph

#include "server/net/client_files.h"

#include "server/base/error.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace heliograph {

namespace {

constexpr uintmax_t FILE_LIMIT = 16u << 20;    // bytes
constexpr uintmax_t FOLDER_LIMIT = 64u << 20;  // bytes

constexpr struct {
    const char* ending;
    const char* type;
} MIME_TYPES[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".mjs", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".map", "application/json"},
    {".json", "application/json"},
    {".webmanifest", "application/manifest+json"},
    {".svg", "image/svg+xml"},
    {".ico", "image/x-icon"},
    {".png", "image/png"},
    {".jpg", "image/jpeg"},
    {".webp", "image/webp"},
    {".woff2", "font/woff2"},
    {".wasm", "application/wasm"},
    {".txt", "text/plain; charset=utf-8"},
};

/// 64 bits of the content (FNV-1a), as a weak ETag: its compressed forms have it too.
std::string tagOf(std::string_view bytes) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    char text[24];
    std::snprintf(text, sizeof text, "W/\"%016llx\"", static_cast<unsigned long long>(hash));
    return text;
}

/// Moves compressed forms to the files that they are of.
void takeCompressed(ClientFiles& files) {
    for (auto i = files.begin(); i != files.end();) {
        const std::string& path = i->first;
        const bool gzip = path.ends_with(".gz"), brotli = path.ends_with(".br");
        const auto plain = gzip || brotli ? files.find(path.substr(0, path.size() - 3)) : files.end();
        if (plain == files.end()) {
            ++i;
            continue;
        }
        (gzip ? plain->second.gzip : plain->second.brotli) = std::move(i->second.bytes);
        i = files.erase(i);
    }
}

/// Whether the list of encodings names this one, other than by q=0.
bool accepts(std::string_view list, std::string_view name) {
    while (!list.empty()) {
        const size_t comma = std::min(list.find(','), list.size());
        std::string item;
        for (const char c : list.substr(0, comma))
            if (c != ' ' && c != '\t') item += c;
        const size_t semicolon = std::min(item.find(';'), item.size());
        const std::string quality = item.substr(semicolon);
        if (item.substr(0, semicolon) == name)
            return !(quality.starts_with(";q=0") && quality.find_first_of("123456789") == std::string::npos);
        list.remove_prefix(std::min(comma + 1, list.size()));
    }
    return false;
}

}  // namespace

EncodedFile encodedFor(const ClientFile& file, std::string_view acceptEncoding) {
    EncodedFile best{file.bytes, nullptr};
    const auto offer = [&](const std::string& bytes, const char* name) {
        if (!bytes.empty() && bytes.size() < best.bytes.size() && accepts(acceptEncoding, name)) best = {bytes, name};
    };
    offer(file.gzip, "gzip");
    offer(file.brotli, "br");
    return best;
}

bool namesItsContent(std::string_view path) {
    const size_t dash = path.rfind('-');
    if (dash == std::string_view::npos || path.size() < dash + 10 || path[dash + 9] != '.') return false;
    return std::ranges::all_of(path.substr(dash + 1, 8),
                               [](char c) { return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z'); });
}

std::string mimeTypeOf(const std::string& path) {
    for (const auto& row : MIME_TYPES) {
        if (path.ends_with(row.ending)) return row.type;
    }
    return "application/octet-stream";
}

ClientFiles readClientFiles(const std::string& folder) {
    namespace fs = std::filesystem;
    ClientFiles files;
    std::error_code error;
    uintmax_t total = 0;
    for (fs::recursive_directory_iterator i(folder, error), end; !error && i != end; i.increment(error)) {
        if (i->is_symlink() || !i->is_regular_file()) continue;
        uintmax_t size = i->file_size();
        total += size;
        if (size > FILE_LIMIT || total > FOLDER_LIMIT) {
            throw InputError(i->path().string(), std::to_string(size) + " bytes", "16 MiB a file, 64 MiB in all");
        }
        std::ifstream in(i->path(), std::ios::binary);
        std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
        std::string path = "/" + fs::relative(i->path(), folder).generic_string();
        std::string tag = tagOf(bytes);
        files[path] = {mimeTypeOf(path), std::move(bytes), {}, {}, std::move(tag)};
    }
    if (error) throw InputError(folder, error.message(), "the folder of the built client");
    takeCompressed(files);
    auto index = files.find("/index.html");
    if (index == files.end()) throw InputError(folder, "no index.html", "the folder of the built client");
    ClientFile copy = index->second;
    files["/"] = std::move(copy);
    return files;
}

}  // namespace heliograph

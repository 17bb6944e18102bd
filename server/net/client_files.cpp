#include "server/net/client_files.h"

#include "server/base/error.h"

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

}  // namespace

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
        files[path] = {mimeTypeOf(path), std::move(bytes)};
    }
    if (error) throw InputError(folder, error.message(), "the folder of the built client");
    auto index = files.find("/index.html");
    if (index == files.end()) throw InputError(folder, "no index.html", "the folder of the built client");
    ClientFile copy = index->second;
    files["/"] = std::move(copy);
    return files;
}

}  // namespace heliograph

#pragma once
// The files of the browser client, read once at start. Requests are answered from this list alone, so no path that a
// browser sends ever reaches the file system.

#include <map>
#include <string>
#include <string_view>

namespace heliograph {

struct ClientFile {
    std::string mimeType;
    std::string bytes;
    std::string gzip = {};    // the same compressed, as the build left it beside the file; empty: not there
    std::string brotli = {};  // the same
    std::string tag = {};     // an ETag of the bytes; empty: none
};

/// What is sent of a file.
struct EncodedFile {
    std::string_view bytes;
    const char* encoding = nullptr;  // for Content-Encoding; nullptr: as it is
};

/// The smallest form that an `Accept-Encoding` header allows; an encoding with q=0 is not allowed.
EncodedFile encodedFor(const ClientFile& file, std::string_view acceptEncoding);

/// Whether the name holds a hash of the content, as "/app-1A2B3C4D.js": it never changes under that name.
bool namesItsContent(std::string_view path);

/// By path as the browser asks for it: "/", "/main.js".
using ClientFiles = std::map<std::string, ClientFile, std::less<>>;

/// Reads all regular files under `folder`; index.html is also "/". A file beside it that ends in
/// .gz or .br is its compressed form and no file of its own. Links are left out. Throws InputError if there is no
/// index.html, or if a file is over 16 MiB or all together are over 64 MiB.
ClientFiles readClientFiles(const std::string& folder);

/// By the name's ending; "application/octet-stream" for an unknown one.
std::string mimeTypeOf(const std::string& path);

}  // namespace heliograph

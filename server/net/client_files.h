#pragma once
// The files of the browser client, read once at start. Requests are answered from this list alone, so no path that a
// browser sends ever reaches the file system.

#include <map>
#include <string>

namespace heliograph {

struct ClientFile {
    std::string mimeType;
    std::string bytes;
};

/// By path as the browser asks for it: "/", "/main.js".
using ClientFiles = std::map<std::string, ClientFile, std::less<>>;

/// Reads all regular files under `folder`; index.html is also "/". Links are left out. Throws InputError if there is no
/// index.html, or if a file is over 16 MiB or all together are over 64 MiB.
ClientFiles readClientFiles(const std::string& folder);

/// By the name's ending; "application/octet-stream" for an unknown one.
std::string mimeTypeOf(const std::string& path);

}  // namespace heliograph

#pragma once
// heliograph.toml: the options of `serve` as TOML, `option = value` with the flag's name without its dashes; settings that
// viewers start with stand under [set].

#include "server/operations/serve_options.h"

namespace heliograph {

constexpr size_t CONFIG_FILE_BYTES = 1 << 20;  // of a file, at most

/// The values in the order of the file; sources say "FILE:LINE: KEY". A byte order mark and CRLF are taken. Throws InputError,
/// with file and line, for a file that cannot be read, is none or too large, for what is no TOML and for an unknown key.
std::vector<GivenValue> readConfigFile(const std::string& path);
/// The same of a text; `path` is only named.
std::vector<GivenValue> parseConfig(std::string_view text, const std::string& path);

}  // namespace heliograph

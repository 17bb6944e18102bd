#include "server/operations/config_file.h"

#include "server/base/error.h"

#define TOML_HEADER_ONLY 0
#include <toml++/toml.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <optional>
#include <system_error>

namespace heliograph {

namespace {

using ValueKind = GivenValue::Kind;

std::string at(const std::string& path, const toml::source_region& source, std::string_view key = {}) {
    std::string text = path + ":" + std::to_string(source.begin.line);
    return key.empty() ? text : text + ": " + std::string(key);
}

/// The value as text; nothing for what no option takes.
std::optional<std::pair<ValueKind, std::string>> scalar(const toml::node& node) {
    if (const auto* text = node.as_string()) return {{ValueKind::text, text->get()}};
    if (const auto* number = node.as_integer()) return {{ValueKind::number, std::to_string(number->get())}};
    if (const auto* yes = node.as_boolean()) return {{ValueKind::boolean, yes->get() ? "true" : "false"}};
    if (const auto* real = node.as_floating_point()) {
        char text[32];
        auto end = std::to_chars(text, text + sizeof text, real->get()).ptr;
        return {{ValueKind::number, std::string(text, end)}};
    }
    return std::nullopt;
}

GivenValue listOf(const toml::array& array, const std::string& option, const std::string& source) {
    GivenValue given{option, ValueKind::text, {}, source};
    for (const toml::node& node : array) {
        const toml::value<std::string>* text = node.as_string();
        if (!text) throw InputError(source, "a list with something that is no text", "texts in quotes, as [\"one\", \"two\"]");
        given.texts.push_back(text->get());
    }
    return given;
}

/// [set]: a setting a line.
void readSettings(const toml::table& table, const std::string& path, std::vector<GivenValue>& values) {
    for (const auto& [key, node] : table) {
        const std::string source = at(path, node.source(), "set." + std::string(key.str()));
        auto value = scalar(node);
        if (!value) throw InputError(source, "no plain value", "a number, true, false or a text in quotes");
        values.push_back({"set", ValueKind::text, {std::string(key.str()) + "=" + value->second}, source});
    }
}

void readNode(const std::string& key, const toml::node& node, const std::string& path, std::vector<GivenValue>& values) {
    const std::string source = at(path, node.source(), key);
    ServeOptions unused;
    if (!optionNamed(key)) apply({key, ValueKind::text, {}, source}, unused);  // says what was probably meant
    if (const toml::table* table = node.as_table()) {
        if (key == "set") return readSettings(*table, path, values);
        throw InputError(source, "a table", "a plain value; only [set] is a table");
    }
    if (const toml::array* array = node.as_array()) {
        values.push_back(listOf(*array, key, source));
        return;
    }
    auto value = scalar(node);
    if (!value) throw InputError(source, "a date or a time", "a number, true, false or a text in quotes");
    values.push_back({key, value->first, {value->second}, source});
}

struct Descriptor {
    int fd;
    ~Descriptor() {
        if (fd >= 0) close(fd);
    }
};

}  // namespace

std::vector<GivenValue> parseConfig(std::string_view text, const std::string& path) {
    toml::table table;
    try {
        table = toml::parse(text, path);
    } catch (const toml::parse_error& error) {
        throw InputError(at(path, error.source()), std::string(error.description()), "TOML, as max-viewers = 32");
    }
    std::vector<GivenValue> values;
    for (const auto& [key, node] : table) readNode(std::string(key.str()), node, path, values);
    return values;
}

std::vector<GivenValue> readConfigFile(const std::string& path) {
    const auto problem = [&](const std::string& found) -> InputError {
        return {path, found, "a text file (TOML) that can be read"};
    };
    // Not blocking: a pipe without a writer would wait for ever.
    Descriptor file{open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    struct stat status {};
    if (file.fd < 0 || fstat(file.fd, &status) != 0)
        throw problem("cannot be read (" + std::generic_category().message(errno) + ")");
    if (S_ISDIR(status.st_mode)) throw problem("is a folder");
    if (!S_ISREG(status.st_mode) && !S_ISCHR(status.st_mode)) throw problem("is no regular file");
    std::string text;
    char piece[4096];
    for (ssize_t count; (count = read(file.fd, piece, sizeof piece)) != 0;) {
        if (count < 0) throw problem("cannot be read (" + std::generic_category().message(errno) + ")");
        text.append(piece, static_cast<size_t>(count));
        if (text.size() > CONFIG_FILE_BYTES) throw problem("is larger than 1 MiB");
    }
    return parseConfig(text, path);
}

}  // namespace heliograph

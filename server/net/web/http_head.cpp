#include "server/net/web/http_head.h"

#include "server/net/limits.h"

#include <algorithm>
#include <cctype>

namespace heliograph {

namespace {

constexpr std::string_view LINE_END = "\r\n", HEAD_END = "\r\n\r\n";

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

bool sameWord(std::string_view a, std::string_view b) {
    return std::ranges::equal(a, b, [](char x, char y) { return lower(x) == lower(y); });
}

bool isTokenCharacter(unsigned char c) {
    return std::isalnum(c) || std::string_view("!#$%&'*+-.^_`|~").find(static_cast<char>(c)) != std::string_view::npos;
}

bool isToken(std::string_view text) { return !text.empty() && std::ranges::all_of(text, isTokenCharacter); }

std::string_view trimmed(std::string_view text) {
    const size_t begin = text.find_first_not_of(" \t");
    if (begin == text.npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Nothing where a percent sign is not followed by two hexadecimal digits.
std::optional<std::string> percentDecoded(std::string_view text) {
    std::string result;
    for (size_t i = 0; i < text.size(); i++) {
        if (text[i] != '%') {
            result += text[i];
            continue;
        }
        if (i + 2 >= text.size() || !std::isxdigit(static_cast<unsigned char>(text[i + 1])) ||
            !std::isxdigit(static_cast<unsigned char>(text[i + 2])))
            return std::nullopt;
        result += static_cast<char>(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16));
        i += 2;
    }
    return result;
}

HttpFault malformed(const std::string& why) { return {400, why}; }

/// Sets path and, of an absolute target, the host.
std::optional<HttpFault> readTarget(std::string_view target, HttpRequest& request) {
    if (std::ranges::any_of(target, [](unsigned char c) { return c <= 0x20 || c >= 0x7f; }))
        return malformed("the target holds characters that have to be percent-encoded");
    for (std::string_view scheme : {"http://", "https://"}) {
        if (!target.starts_with(scheme)) continue;
        target.remove_prefix(scheme.size());
        const size_t end = std::min(target.find_first_of("/?"), target.size());
        request.host = target.substr(0, end);
        target.remove_prefix(end);
        if (target.empty()) target = "/";
    }
    if (!target.starts_with('/')) return malformed("the target begins with /");
    std::optional<std::string> path = percentDecoded(target.substr(0, target.find('?')));
    if (!path) return malformed("a percent sign in the target is followed by two hexadecimal digits");
    request.path = std::move(*path);
    return std::nullopt;
}

std::optional<HttpFault> readRequestLine(std::string_view line, HttpRequest& request) {
    const size_t first = line.find(' '), second = line.rfind(' ');
    if (first == line.npos || first == second) return malformed("a request begins with METHOD TARGET HTTP/1.1");
    const std::string_view version = line.substr(second + 1), target = line.substr(first + 1, second - first - 1);
    request.method = line.substr(0, first);
    if (!isToken(request.method)) return malformed("the method is a word");
    if (version.size() != 8 || !version.starts_with("HTTP/") || !std::isdigit(static_cast<unsigned char>(version[5])) ||
        version[6] != '.' || !std::isdigit(static_cast<unsigned char>(version[7])))
        return malformed("a request begins with METHOD TARGET HTTP/1.1");
    if (version != "HTTP/1.1" && version != "HTTP/1.0") return HttpFault{505, "HTTP/1.1 is spoken here"};
    request.keepAlive = version == "HTTP/1.1";
    if (target.size() > REQUEST_TARGET_LIMIT) return HttpFault{414, "the target is too long"};
    return readTarget(target, request);
}

std::optional<HttpFault> readHeader(std::string_view line, HttpRequest& request) {
    if (line.starts_with(' ') || line.starts_with('\t')) return malformed("headers are not folded");
    const size_t colon = line.find(':');
    if (colon == line.npos || !isToken(line.substr(0, colon))) return malformed("a header is NAME: VALUE");
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (std::ranges::any_of(value, [](unsigned char c) { return (c < 0x20 && c != '\t') || c == 0x7f; }))
        return malformed("a header holds a control character");
    if (request.headers.size() >= REQUEST_HEADERS_LIMIT) return HttpFault{431, "too many headers"};
    std::string name(line.substr(0, colon));
    std::ranges::transform(name, name.begin(), lower);
    request.headers.emplace_back(std::move(name), value);
    return std::nullopt;
}

/// What only shows when all headers are there.
std::optional<HttpFault> judge(HttpRequest& request, bool version11) {
    if (request.count("host") > 1) return malformed("Host stands there more than once");
    if (version11 && request.count("host") == 0) return malformed("Host is missing");
    if (request.host.empty()) request.host = request.header("host");
    const bool sane = std::ranges::all_of(request.host, [](unsigned char c) {
        return std::isalnum(c) || std::string_view("-._:[]~%").find(static_cast<char>(c)) != std::string_view::npos;
    });
    if (!sane || (version11 && request.host.empty())) return malformed("Host is NAME or NAME:PORT");
    const std::string_view length = request.header("content-length");
    if (request.count("content-length") > 1 || length.find_first_not_of("0123456789") != length.npos)
        return malformed("Content-Length is one number");
    if (request.count("transfer-encoding") > 0 || length.find_first_not_of('0') != length.npos)
        return HttpFault{413, "requests have no body here"};
    if (request.lists("connection", "close")) request.keepAlive = false;
    return std::nullopt;
}

}  // namespace

std::string_view HttpRequest::header(std::string_view name) const {
    for (const auto& [known, value] : headers) {
        if (known == name) return value;
    }
    return {};
}

size_t HttpRequest::count(std::string_view name) const {
    return static_cast<size_t>(std::ranges::count(headers, name, [](const auto& h) { return std::string_view(h.first); }));
}

bool HttpRequest::lists(std::string_view name, std::string_view word) const {
    for (const auto& [known, value] : headers) {
        if (known != name) continue;
        for (std::string_view rest = value; !rest.empty();) {
            const size_t comma = std::min(rest.find(','), rest.size());
            if (sameWord(trimmed(rest.substr(0, comma)), word)) return true;
            rest.remove_prefix(std::min(comma + 1, rest.size()));
        }
    }
    return false;
}

HttpHead readHttpHead(std::string_view bytes) {
    const size_t skipped = bytes.starts_with(LINE_END) ? LINE_END.size() : 0;  // an empty line before a request is allowed
    const std::string_view text = bytes.substr(skipped);
    // Told at once of who speaks something else here, as TLS.
    if (!text.empty() && text != "\r" && !isTokenCharacter(static_cast<unsigned char>(text.front())))
        return {bytes.size(), malformed("a request begins with METHOD TARGET HTTP/1.1")};
    const size_t lineEnd = text.find(LINE_END);
    const size_t most = REQUEST_TARGET_LIMIT + 64;  // of the request line
    if (std::min(lineEnd, text.size()) > most) return {bytes.size(), HttpFault{414, "the target is too long"}};
    if (lineEnd == text.npos) {
        if (text.find('\n') != text.npos) return {bytes.size(), malformed("lines end with CR LF")};
        return {};
    }
    HttpRequest request;
    if (auto fault = readRequestLine(text.substr(0, lineEnd), request)) return {bytes.size(), *fault};
    const bool version11 = request.keepAlive;
    const size_t end = text.find(HEAD_END);
    if (std::min(end, text.size()) > REQUEST_HEAD_LIMIT) return {bytes.size(), HttpFault{431, "the headers are too long"}};
    if (end == text.npos) return {};
    for (size_t at = lineEnd + 2; at < end + 2;) {
        const size_t stop = text.find(LINE_END, at);
        if (auto fault = readHeader(text.substr(at, stop - at), request)) return {bytes.size(), *fault};
        at = stop + 2;
    }
    if (auto fault = judge(request, version11)) return {bytes.size(), *fault};
    return {skipped + end + HEAD_END.size(), std::move(request)};
}

}  // namespace heliograph

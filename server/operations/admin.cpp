#include "server/operations/admin.h"

#include <charconv>

namespace heliograph {

namespace {

using Kind = AdminRequest::Kind;

struct Row {
    std::string_view method, path;  // a path that ends in '/' goes on with a number or name
    Kind kind;
};

constexpr Row ROWS[] = {
    {"GET", "/admin/viewers", Kind::listViewers}, {"DELETE", "/admin/viewers/", Kind::disconnect},
    {"GET", "/admin/scenes", Kind::listScenes},   {"POST", "/admin/scenes/", Kind::openScene},
    {"POST", "/admin/drain", Kind::drain},        {"DELETE", "/admin/drain", Kind::admit},
};

bool fits(const Row& row, std::string_view path) {
    return row.path.ends_with('/') ? path.size() > row.path.size() && path.starts_with(row.path) : path == row.path;
}

}  // namespace

AdminRequest parseAdminRequest(std::string_view method, std::string_view path) {
    AdminRequest request;
    for (const Row& row : ROWS) {
        if (!fits(row, path)) continue;
        if (row.method != method) {
            request.kind = Kind::otherMethod;
            request.methods += (request.methods.empty() ? "" : ", ") + std::string(row.method);
            continue;
        }
        const std::string_view rest = path.substr(row.path.size());
        request.kind = row.kind;
        if (row.kind == Kind::openScene) request.scene = rest;
        if (row.kind != Kind::disconnect) return request;
        const auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), request.viewer);
        if (error != std::errc() || stop != rest.data() + rest.size()) request.kind = Kind::unknown;
        return request;
    }
    return request;
}

}  // namespace heliograph

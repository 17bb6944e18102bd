#include "server/operations/admin.h"

#include <charconv>

namespace heliograph {

namespace {

using AdminKind = AdminRequest::Kind;

struct Row {
    std::string_view method, path;  // a path that ends in '/' goes on with a number or name
    AdminKind kind;
};

constexpr Row ROWS[] = {
    {"GET", "/admin/viewers", AdminKind::listViewers}, {"DELETE", "/admin/viewers/", AdminKind::disconnect},
    {"GET", "/admin/scenes", AdminKind::listScenes},   {"POST", "/admin/scenes/", AdminKind::openScene},
    {"POST", "/admin/drain", AdminKind::drain},        {"DELETE", "/admin/drain", AdminKind::admit},
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
            request.kind = AdminKind::otherMethod;
            request.methods += (request.methods.empty() ? "" : ", ") + std::string(row.method);
            continue;
        }
        const std::string_view rest = path.substr(row.path.size());
        request.kind = row.kind;
        if (row.kind == AdminKind::openScene) request.scene = rest;
        if (row.kind != AdminKind::disconnect) return request;
        const auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), request.viewer);
        if (error != std::errc() || stop != rest.data() + rest.size()) request.kind = AdminKind::unknown;
        return request;
    }
    return request;
}

}  // namespace heliograph

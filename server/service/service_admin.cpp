// What admins do with the service; the socket has asked them for their token.

#include "server/base/log.h"
#include "server/operations/admin.h"
#include "server/service/service.h"

#include <algorithm>

namespace heliograph {

namespace {

SocketHandler::AdminAnswer refusal(unsigned status, const std::string& why) {
    return {status, nlohmann::ordered_json{{"error", why}}.dump() + "\n"};
}

}  // namespace

SocketHandler::AdminAnswer Service::admin(std::string_view method, std::string_view path) {
    using Kind = AdminRequest::Kind;
    const AdminRequest request = parseAdminRequest(method, path);
    nlohmann::ordered_json json;
    unsigned status = 200;
    switch (request.kind) {
        case Kind::unknown: return refusal(404, "nothing of that name is here");
        case Kind::otherMethod: return refusal(405, "allowed: " + request.methods);
        case Kind::listViewers: json = {{"viewers", viewersJson()}}; break;
        case Kind::disconnect:
            if (!disconnect(request.viewer)) return refusal(404, "no viewer " + std::to_string(request.viewer));
            json = {{"disconnected", request.viewer}};
            break;
        case Kind::listScenes:
            json["scenes"] = nlohmann::ordered_json::array();
            for (const SceneRecipe& scene : options_.scenes) json["scenes"].push_back(scene.name);
            break;
        case Kind::openScene:
            if (std::ranges::find(options_.scenes, request.scene, &SceneRecipe::name) == options_.scenes.end())
                return refusal(404, "no such scene is on offer");
            try {
                openForAdmin(request.scene);
            } catch (const InputError& error) {
                return refusal(409, error.what());
            }
            json = {{"opening", request.scene}};
            status = 202;
            break;
        case Kind::drain:
        case Kind::admit:
            closed_ = request.kind == Kind::drain;
            json = {{"draining", closed_.load()}};
            break;
    }
    if (method != "GET") log().info("admin: {} {}", method, path);
    return {status, json.dump() + "\n"};
}

nlohmann::ordered_json Service::viewersJson() const {
    std::lock_guard lock(mutex_);
    auto list = nlohmann::ordered_json::array();
    const auto now = std::chrono::steady_clock::now();
    for (const auto& [viewer, entry] : entries_) {
        list.push_back({{"viewer", viewer},
                        {"address", entry.socket->address()},
                        {"seconds", std::chrono::duration<double>(now - entry.since).count()}});
    }
    return list;
}

bool Service::disconnect(uint32_t viewer) {
    std::shared_ptr<ViewerSocket> socket;
    {
        std::lock_guard lock(mutex_);
        const auto entry = entries_.find(viewer);
        if (entry == entries_.end()) return false;
        socket = entry->second.socket;
    }
    socket->close(CloseCode::dismissed, "an admin closed this connection");
    return true;
}

/// Loads the scene, so that viewers find it ready; it stays as scenes do that nobody looks at.
void Service::openForAdmin(const std::string& name) {
    SceneListener listener;
    listener.progress = [](const std::string&, double) {};
    listener.ready = [name](std::shared_ptr<ResidentScene>) { log().info("{}: opened for an admin", name); };
    listener.failed = [name](const std::string& why, std::exception_ptr) { log().warn("{}: {}", name, why); };
    adminScenes_[name] = cache_.open(name, std::move(listener));
    letViewersGoFirst();
}

}  // namespace heliograph

#pragma once
// Small pictures of the scenes on offer, for lists of them. Each is rendered once, when somebody first asks for it; a scene that
// is not ready then is loaded for its picture alone and let go of. Who wants to look at a scene goes first: what gives way begins
// again when it is asked for again.

#include "server/net/socket_server.h"
#include "server/stream/session_host.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <thread>

namespace heliograph {

/// A JPEG of the scene as a viewer sees it first, 160 x 90. Takes turns with those who look at scenes. Empty where `stop` is
/// asked for. Throws what the renderer does.
std::string paintThumbnail(const ResidentScene& resident, const Settings& settings, Turns& turns, std::stop_token stop);

class Thumbnails {
public:
    /// Opens a scene, as SessionHost::openScene.
    using Open = std::function<std::shared_ptr<void>(const std::string& name, SceneListener listener)>;
    /// As paintThumbnail.
    using Paint = std::function<std::string(const ResidentScene& resident, std::stop_token stop)>;

    /// `scenes`: names of those that have pictures. `failureLasts`: how long one that failed is not tried again.
    Thumbnails(const std::vector<std::string>& scenes, Open open, Paint paint,
               std::chrono::milliseconds failureLasts = std::chrono::minutes(1));

    /// What there is by now; where there is nothing yet, it is the next to be made. Does not wait.
    Thumbnail ask(std::string_view scene);
    /// Somebody waits for a scene to look at: a load for a picture ends.
    void giveWay();

private:
    /// A scene on its way to the one who paints it.
    struct Attempt {
        std::mutex mutex;
        std::condition_variable_any changed;
        std::shared_ptr<ResidentScene> scene;
        std::string failure;
        bool gaveWay = false;
    };
    struct Entry {
        Thumbnail picture;
        std::chrono::steady_clock::time_point failed;
    };

    void run(std::stop_token stop);
    std::optional<std::string> next(std::stop_token stop);
    Thumbnail make(const std::string& scene, std::stop_token stop);
    std::shared_ptr<ResidentScene> open(const std::string& scene, Attempt& attempt, std::stop_token stop);

    const Open open_;
    const Paint paint_;
    const std::chrono::milliseconds failureLasts_;
    std::mutex mutex_;
    std::condition_variable_any asked_;
    std::map<std::string, Entry, std::less<>> pictures_;
    std::deque<std::string> wanted_;    // the one asked for last is the next
    std::shared_ptr<Attempt> attempt_;  // in progress
    std::jthread thread_;
};

}  // namespace heliograph

#pragma once
// What sessions and views need of the world around them, in memory: a device that paints in grey, a host, a socket.

#include "server/base/error.h"
#include "server/stream/session.h"

#include "tests/support/direct_renderer.h"
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <new>

namespace heliograph::test {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto PATIENCE = 30s;

/// Paints everything in one grey.
class GreyDevice : public Device {
public:
    /// While held no tile is finished.
    void hold(bool on) {
        std::lock_guard lock(mutex);
        held = on;
        changed.notify_all();
    }
    DepthAnswer depthAlong(const ViewRay&) override { return depth; }

    DepthAnswer depth{true, std::nullopt};
    std::mutex mutex;
    std::condition_variable_any changed;
    bool held = false;
    std::atomic<bool> poor{false};  // has no memory for any tile
    DeviceInfo info() const override { return {"embree", "for tests", "none", 1}; }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void render(const FrameRequest&, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        for (const Tile& tile : tiles) {
            {
                std::unique_lock lock(mutex);
                changed.wait(lock, stop, [&] { return !held; });
            }
            if (stop.stop_requested()) return;
            if (poor) throw std::bad_alloc();
            TileResult result;
            result.tile = tile;
            result.device = "embree";
            result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, vec4(0.5f, 0.5f, 0.5f, 0.25f));
            result.rays[RayKind::primary] = result.radianceSum.size();
            sink(std::move(result));
        }
    }
};

inline std::shared_ptr<ResidentScene> residentScene(const std::string& name, bool withPath = true,
                                                    std::shared_ptr<Device> device = std::make_shared<GreyDevice>()) {
    auto scene = std::make_shared<Scene>();
    scene->name = name;
    scene->environment.image = NO_INDEX;
    scene->cameras.push_back({"start", vec3(1, 2, 3)});
    if (withPath) {
        CameraPath path;
        path.seconds = 0.1f;
        path.keys = {{vec3(5, 0, 0), vec3(0)}, {vec3(0, 0, 5), vec3(0)}};
        scene->paths.push_back(path);
    }
    return std::make_shared<ResidentScene>(
        ResidentScene{scene, std::make_shared<DirectRenderer>(std::move(device)), explainEffects(*scene), {}});
}

class FakeHost : public SessionHost {
public:
    std::vector<SceneRecipe> scenes() const override { return {{"first", "one"}, {"second", "two"}, {"bare", "no path"}}; }
    std::shared_ptr<void> openScene(const std::string& name, SceneListener listener) override {
        opened.push_back(name);
        if (full) throw InputError("scene.name", "no room", "later");
        if (poor) throw std::bad_alloc();
        if (manual) listeners.push_back(std::move(listener));
        else listener.ready(residentScene(name, name != "bare", device));
        return std::make_shared<int>(0);
    }
    uint64_t grantPixels(uint32_t, uint64_t wanted) override {
        if (poor) throw std::bad_alloc();
        return std::min(wanted, pixelLimit);
    }
    std::shared_ptr<void> look(uint32_t view) override {
        if (crowded && looking[view] > 0) return nullptr;
        looking[view]++;
        return {this, [view](FakeHost* host) { host->looking[view]--; }};
    }
    std::vector<std::string> devices() const override { return {"auto", "embree", "raster", "hybrid"}; }
    void viewEnded(std::shared_ptr<View> view) override {
        views_.remove(*view);
        endedViews.push_back(std::move(view));
    }
    void viewLeft(std::shared_ptr<View> view) override { leftViews.push_back(std::move(view)); }
    Views& views() override { return views_; }
    size_t viewerCount() const override {
        if (poor) throw std::bad_alloc();
        return 3;
    }
    Turns& turns() override { return turns_; }
    Metrics& metrics() override { return metrics_; }

    std::shared_ptr<GreyDevice> device = std::make_shared<GreyDevice>();
    std::vector<std::string> opened;
    std::vector<SceneListener> listeners;
    bool manual = false, full = false;
    bool poor = false;                // no memory for anything
    bool crowded = false;             // nor for who watches
    std::map<uint32_t, int> looking;  // by view
    uint64_t pixelLimit = 3'000'000;
    Views views_;
    Turns turns_;
    Metrics metrics_;
    std::vector<std::shared_ptr<View>> endedViews;  // go first
    std::vector<std::shared_ptr<View>> leftViews;
};

/// Keeps what is sent. Frames are acknowledged by the test.
class FakeSocket : public ViewerSocket {
public:
    void sendText(std::string text) override {
        std::lock_guard lock(mutex);
        texts.push_back(json::parse(text));
        changed.notify_all();
    }
    std::optional<uint32_t> sendPicture(OutgoingPicture picture) override {
        std::lock_guard lock(mutex);
        headers.push_back(readFrameHeader(std::span(picture.bytes).subspan(SOCKET_HEADROOM)));
        payloads.emplace_back(picture.bytes.begin() + SOCKET_HEADROOM + FRAME_HEADER_BYTES, picture.bytes.end());
        changed.notify_all();
        return std::nullopt;
    }
    void close(CloseCode code, const std::string& reason) override {
        std::lock_guard lock(mutex);
        closed = code;
        closeReason = reason;
        changed.notify_all();
    }
    template <typename Condition>
    bool until(Condition condition) {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, PATIENCE, condition);
    }
    /// The last message of that type, or null.
    json last(const std::string& type) {
        std::lock_guard lock(mutex);
        for (auto i = texts.rbegin(); i != texts.rend(); ++i) {
            if ((*i)["type"] == type) return *i;
        }
        return nullptr;
    }
    bool untilFrame(size_t count) {
        return until([&] { return headers.size() >= count; });
    }

    std::mutex mutex;
    std::condition_variable changed;
    std::vector<json> texts;
    std::vector<FrameHeader> headers;
    std::vector<std::vector<uint8_t>> payloads;
    std::optional<CloseCode> closed;
    std::string closeReason;
};

/// One viewer, on a host of its own or on that of others.
struct Line {
    explicit Line(const std::string& token = "", bool authorized = false) { connect(7, token, authorized); }
    Line(std::shared_ptr<FakeHost> shared, uint32_t viewer) : host_(std::move(shared)) {
        connect(viewer, "", false);
        session->begin();
    }
    void connect(uint32_t viewer, const std::string& token, bool authorized) {
        Session::Options options;
        options.defaults.samples = 1;
        options.token = token;
        options.authorized = authorized;
        session = std::make_shared<Session>(viewer, host, socket, options);
    }
    void say(const json& message) { session->receive(message.dump()); }
    void size(uint32_t width = 64, uint32_t height = 48, uint32_t inputId = 1) {
        say({{"type", "resolution"}, {"width", width}, {"height", height}, {"inputId", inputId}});
    }
    void look(uint32_t inputId, bool moving = false) {
        say({{"type", "camera"},
             {"inputId", inputId},
             {"position", {inputId, 0, 0}},
             {"forward", {0, 0, -1}},
             {"up", {0, 1, 0}},
             {"fieldOfView", 60},
             {"moving", moving}});
    }
    void ack(uint32_t frameId) { say({{"type", "ack"}, {"frameId", frameId}, {"presentedMs", 20}}); }

    std::shared_ptr<FakeHost> host_ = std::make_shared<FakeHost>();
    FakeHost& host = *host_;
    std::shared_ptr<FakeSocket> socket = std::make_shared<FakeSocket>();
    std::shared_ptr<Session> session;
};

}  // namespace heliograph::test

#pragma once
// A server with a device that traces nothing, and clients over real sockets.

#include "server/service/service.h"

#include "server/base/error.h"
#include "server/film/film_shares.h"
#include "tests/support/web_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include <deque>
#include <optional>
#include <filesystem>
#include <latch>
#include <semaphore>
#include <thread>

namespace heliograph::service_test {

using nlohmann::json;
using test::WebClient;
using testing::HasSubstr;

inline const std::string OURS = "Sec-WebSocket-Protocol: heliograph.v1\r\n";

class GreyDevice : public Device {
public:
    DeviceInfo info() const override {
        DeviceInfo info{"embree", "for tests", "none", 1};
        info.overlaps = true;  // as the real ones: called once, from the thread of the view
        return info;
    }
    void load(std::shared_ptr<const Scene>, const Settings&, const Progress&) override {}
    void render(const FrameRequest&, std::span<const Tile> tiles, const TileSink& sink, std::stop_token stop) override {
        for (const Tile& tile : tiles) {
            if (stop.stop_requested()) return;
            TileResult result;
            result.tile = tile;
            result.device = "embree";
            result.radianceSum.assign(static_cast<size_t>(tile.size.x) * tile.size.y, vec4(0.5f, 0.5f, 0.5f, 0.25f));
            sink(std::move(result));
        }
    }
};

inline ServiceOptions options() {
    ServiceOptions o;
    o.socket.listen = {parseListenAddress("127.0.0.1:0")};
    o.socket.files["/"] = {"text/html", "hello"};
    o.scenes = {{"first", "one"}, {"second", "two"}, {"bad", "three"}};
    o.defaults.samples = 1;
    o.devices.words = {"auto", "embree"};
    o.devices.nameOf = [](const Settings&) { return "embree"; };
    o.devices.make = [](const std::string&) { return std::make_unique<GreyDevice>(); };
    o.openScene = [](const std::string& name, const Progress&) {
        if (name == "bad") throw InputError("bad", "cannot be read", "another");
        auto scene = std::make_shared<Scene>();
        scene->name = name;
        scene->environment.image = NO_INDEX;
        scene->cameras.push_back({"start", vec3(name == "first" ? 1.0f : 2.0f, 0, 0)});
        return std::shared_ptr<const Scene>(scene);
    };
    return o;
}

/// Whether the condition comes true within 20 s.
template <typename Condition>
inline bool until(Condition condition) {
    for (int round = 0; round < 2000; round++) {
        if (condition()) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

/// A viewer that acknowledges every frame.
struct Guest {
    explicit Guest(int port) : client(port) { client.upgrade(OURS); }
    void say(const json& message) { client.sendText(message.dump()); }
    void size(uint32_t width, uint32_t height, uint32_t inputId) {
        say({{"type", "resolution"}, {"width", width}, {"height", height}, {"inputId", inputId}});
    }
    void look(uint32_t inputId) {
        say({{"type", "camera"},
             {"inputId", inputId},
             {"position", {inputId, 0, 0}},
             {"forward", {0, 0, -1}},
             {"up", {0, 1, 0}},
             {"fieldOfView", 60},
             {"moving", false}});
    }
    /// Reads until a frame shows that input.
    FrameHeader untilInput(uint32_t inputId) {
        for (;;) {
            std::optional<FrameHeader> next = nextFrame();
            if (!next) break;
            const FrameHeader& header = *next;
            say({{"type", "ack"}, {"frameId", header.frameId}, {"presentedMs", 1.0}});
            if (header.inputId == inputId) return header;
        }
        ADD_FAILURE() << "the connection ended before input " << inputId;
        return {};
    }
    /// The next frame, or one that came while something else was read; nothing when the connection has ended.
    std::optional<FrameHeader> nextFrame() {
        if (!passedBy.empty()) {
            const FrameHeader header = passedBy.front();
            passedBy.pop_front();
            return header;
        }
        while (auto message = client.receive()) {
            if (message->opcode == 2) return headerOf(message->bytes);
        }
        return {};
    }
    static FrameHeader headerOf(const std::string& bytes) {
        return readFrameHeader({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
    }
    /// Reads until a text message of that type whose `field` has that value; any value for an empty field.
    json untilText(const std::string& type, const std::string& field = {}, const json& value = {}) {
        while (auto message = client.receive()) {
            if (message->opcode == 2) passedBy.push_back(headerOf(message->bytes));
            if (message->opcode != 1) continue;
            json text = json::parse(message->bytes);
            if (text["type"] == type && (field.empty() || text[field] == value)) return text;
        }
        ADD_FAILURE() << "the connection ended before " << type;
        return {};
    }
    /// How many messages of that type have come by now.
    int waiting(const std::string& type) {
        say({{"type", "ping"}, {"time", 1}});
        int count = 0;
        while (auto message = client.receive()) {
            if (message->opcode == 2) passedBy.push_back(headerOf(message->bytes));
            if (message->opcode != 1) continue;
            const json text = json::parse(message->bytes);
            count += text["type"] == type;
            if (text["type"] == "pong") break;
        }
        return count;
    }
    WebClient client;
    std::deque<FrameHeader> passedBy;  // frames that came while a text was waited for; not acknowledged yet
};

struct Running {
    explicit Running(ServiceOptions o = options()) : service(std::move(o)) {
        service.start([this](std::exception_ptr) { started.count_down(); });
        started.wait();
    }
    /// Whether there are that many by now.
    bool viewers(int count) {
        const std::string line = "heliograph_viewers " + std::to_string(count) + "\n";
        return WebClient(service.port()).get("/metrics").body.find(line) != std::string::npos;
    }
    std::latch started{1};
    Service service;
};

inline test::HttpAnswer ask(int port, const std::string& method, const std::string& path, const std::string& token) {
    WebClient client(port);
    client.send(method + " " + path + " HTTP/1.1\r\nHost: localhost\r\n" +
                (token.empty() ? "" : "Authorization: Bearer " + token + "\r\n") + "\r\n");
    return client.readAnswer();
}

}  // namespace heliograph::service_test

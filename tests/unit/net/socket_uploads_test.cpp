#include "server/net/socket_server.h"

#include "tests/support/web_client.h"
#include "tests/unit/uploads/upload_stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <sstream>
#include <thread>

namespace heliograph::TEST_FILE {
namespace {

using namespace std::chrono_literals;
using test::HttpAnswer;
using test::UploadFolder;
using test::uploadStream;
using test::WebClient;
using testing::HasSubstr;
using testing::IsEmpty;

/// Nobody looks; files come all the same.
class NoViewers : public SocketHandler {
public:
    std::shared_ptr<ViewerPeer> opened(std::shared_ptr<ViewerSocket>, bool) override { return nullptr; }
    void closed(std::shared_ptr<ViewerPeer>, std::optional<CloseCode>) override {}
    void refused(unsigned, const std::string&) override {}
    std::string metricsText() override { return ""; }
    Readiness readiness() override { return {}; }
    bool ending() override { return false; }
    void turned() override {}
};

struct Door {
    explicit Door(UploadLimits limits = {}, const std::string& token = "") {
        store = std::make_shared<UploadStore>(folder.path, limits);
        SocketOptions options;
        options.listen = {parseListenAddress("127.0.0.1:0")};
        options.uploads = store;
        options.token = token;
        server.emplace(std::move(options), handler);
        server->start();
    }
    static std::string head(size_t bytes, const std::string& more = {}) {
        return "POST /uploads HTTP/1.1\r\nHost: localhost\r\n" + more + "Content-Length: " + std::to_string(bytes) + "\r\n\r\n";
    }
    HttpAnswer post(const std::string& stream, const std::string& more = {}) {
        WebClient client(server->port());
        client.send(head(stream.size(), more) + stream);
        return client.readAnswer();
    }
    /// Until nothing is left of what was broken off.
    bool untilEmpty() {
        for (int i = 0; i < 400 && !folder.content().empty(); i++) std::this_thread::sleep_for(50ms);
        return folder.content().empty();
    }

    UploadFolder folder;
    NoViewers handler;
    std::shared_ptr<UploadStore> store;
    std::optional<SocketServer> server;
};

const std::string GOOD = uploadStream({{"a.glb", std::string(300'000, 'g')}}, "a.glb");

TEST(SocketUploads, FilesComeAndAreNamedByAnIdOfTheirOwn) {
    Door door;
    WebClient client(door.server->port());
    client.send(Door::head(GOOD.size()) + GOOD);
    const HttpAnswer answer = client.readAnswer();
    ASSERT_EQ(answer.status, 201) << answer.body;
    const std::string name = nlohmann::json::parse(answer.body)["scene"];
    EXPECT_TRUE(isUploadName(name)) << name;
    const auto file = door.store->fileOf(name);
    ASSERT_TRUE(file.has_value());
    EXPECT_EQ(std::filesystem::file_size(*file), 300'000u);
    const HttpAnswer told = client.get("/uploads");  // on the same connection: the body was no part of this request
    EXPECT_EQ(told.status, 200);
    EXPECT_EQ(nlohmann::json::parse(told.body)["free"], door.store->limits().quota - GOOD.size());
}

TEST(SocketUploads, HostileOnesAreRefusedInWordsAndLeaveNothing) {
    UploadLimits limits;
    limits.bytes = 1 << 20;
    Door door(limits);
    const auto expect = [&](const HttpAnswer& answer, int status, const char* words) {
        EXPECT_EQ(answer.status, status) << words;
        EXPECT_THAT(answer.body, HasSubstr(words));
    };
    expect(door.post(uploadStream({{"../../out.glb", "x"}}, "../../out.glb")), 422, "a path within the upload");
    expect(door.post(uploadStream({{"a.exe", "x"}}, "a.exe")), 422, "\"a.exe\"");
    expect(door.post(uploadStream({{"a.zip", "x"}}, "a.zip")), 422, "unpacked first");
    test::Files many;
    for (int i = 0; i < 10'000; i++) many.push_back({std::to_string(i) + ".png", ""});
    expect(door.post(uploadStream(many, "0.png")), 422, "10000 files");
    expect(door.post(std::string(900'000, 'x')), 422, "at most 512 KiB");
    expect(door.post(Door::head(0)), 422, "upload");
    WebClient large(door.server->port());
    large.send(Door::head(3'000'000'000));
    expect(large.readAnswer(), 413, "at most 1 MiB");
    WebClient endless(door.server->port());
    endless.send("POST /uploads HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n");
    expect(endless.readAnswer(), 411, "Content-Length");
    expect(door.post(GOOD, "Origin: https://elsewhere.example\r\n"), 403, "another origin");
    EXPECT_THAT(door.folder.content(), IsEmpty());
}

TEST(SocketUploads, WhoBreaksOffOrTakesTooLongLeavesNothing) {
    UploadLimits limits;
    limits.seconds = 1;
    Door door(limits);
    {
        WebClient client(door.server->port());
        client.send(Door::head(GOOD.size()) + GOOD.substr(0, 200'000));
        for (int i = 0; i < 400 && door.folder.content().empty(); i++) std::this_thread::sleep_for(50ms);
        EXPECT_FALSE(door.folder.content().empty());
    }
    EXPECT_TRUE(door.untilEmpty());
    WebClient slow(door.server->port());
    slow.send(Door::head(GOOD.size()) + GOOD.substr(0, 200'000));
    const HttpAnswer answer = slow.readAnswer();
    EXPECT_EQ(answer.status, 408);
    EXPECT_THAT(answer.body, HasSubstr("at most 1 s"));
    EXPECT_TRUE(door.untilEmpty());
}

TEST(SocketUploads, ALargeOneComesWholeAlthoughLittleOfItWaits) {
    Door door;
    std::string bytes(12 << 20, '\0');
    for (size_t i = 0; i < bytes.size(); i++) bytes[i] = static_cast<char>(i * 2654435761u >> 24);
    const std::string stream = uploadStream({{"a.glb", bytes}}, "a.glb");
    const HttpAnswer answer = door.post(stream);
    ASSERT_EQ(answer.status, 201) << answer.body;
    const auto file = door.store->fileOf(nlohmann::json::parse(answer.body)["scene"]);
    std::ostringstream text;
    text << std::ifstream(*file, std::ios::binary).rdbuf();
    EXPECT_TRUE(text.str() == bytes);
}

TEST(SocketUploads, OneAddressDoesNotHoldThePlacesOfAll) {
    Door door;
    std::vector<std::unique_ptr<WebClient>> slow;
    for (int i = 0; i < 2; i++) {
        slow.push_back(std::make_unique<WebClient>(door.server->port()));
        slow.back()->send(Door::head(GOOD.size()) + GOOD.substr(0, 200'000));
    }
    while (door.store->freeBytes() > door.store->limits().quota - 2 * GOOD.size()) std::this_thread::sleep_for(10ms);
    const HttpAnswer third = door.post(GOOD);
    EXPECT_EQ(third.status, 507);
    EXPECT_THAT(third.body, HasSubstr("of this address"));
    WebClient other(door.server->port(), "127.0.0.2");
    other.send(Door::head(GOOD.size()) + GOOD);
    EXPECT_EQ(other.readAnswer().status, 201);
}

TEST(SocketUploads, WhoDripsLosesThePlace) {
    UploadLimits limits;
    limits.window = 0.5;
    Door door(limits);
    WebClient client(door.server->port());
    client.send(Door::head(GOOD.size()) + GOOD.substr(0, 200'000));
    const HttpAnswer answer = client.readAnswer();
    EXPECT_EQ(answer.status, 408);
    EXPECT_THAT(answer.body, HasSubstr("8 KiB a second or more"));
    EXPECT_TRUE(door.untilEmpty());
}

TEST(SocketUploads, AFullQuotaIsSaid) {
    UploadLimits limits;
    limits.quota = 400'000;
    Door door(limits);
    EXPECT_EQ(door.post(GOOD).status, 201);
    const HttpAnswer answer = door.post(GOOD);
    EXPECT_EQ(answer.status, 507);
    EXPECT_THAT(answer.body, HasSubstr("room for uploads is full"));
}

TEST(SocketUploads, TheTokenIsAskedForAndWithoutTheOptionThereIsNoDoor) {
    Door door({}, "a secret of sixteen");
    EXPECT_EQ(door.post(GOOD).status, 401);
    EXPECT_EQ(door.post(GOOD, "Authorization: Bearer a secret of sixteen\r\n").status, 201);
    SocketOptions options;
    options.listen = {parseListenAddress("127.0.0.1:0")};
    NoViewers handler;
    SocketServer closed(std::move(options), handler);
    closed.start();
    WebClient client(closed.port());
    client.send(Door::head(GOOD.size()));
    const HttpAnswer answer = client.readAnswer();
    EXPECT_EQ(answer.status, 404);
    EXPECT_THAT(answer.body, HasSubstr("takes no files"));
}

}  // namespace
}  // namespace heliograph::TEST_FILE

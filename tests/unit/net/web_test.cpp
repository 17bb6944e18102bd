// HTTP heads and WebSocket frames as bytes: what is read, what is refused, and that it makes no difference in which pieces
// they come.

#include "server/net/admission.h"
#include "server/net/http_answers.h"
#include "server/net/limits.h"
#include "server/net/token.h"
#include "server/net/web/frames.h"
#include "server/net/web/http_head.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace heliograph {
namespace {

using testing::HasSubstr;

unsigned faultOf(const std::string& bytes) {
    const HttpHead head = readHttpHead(bytes);
    auto* fault = std::get_if<HttpFault>(&head.what);
    return fault ? fault->status : 0;
}

TEST(HttpHead, ReadsARequest) {
    const std::string text =
        "GET /a%20b?c=%zz HTTP/1.1\r\nHost: Example:80\r\nConnection: keep-alive, Upgrade\r\nX-A:  b \r\n\r\nrest";
    const HttpHead head = readHttpHead(text);
    EXPECT_EQ(head.bytes, text.size() - 4);
    const auto& request = std::get<HttpRequest>(head.what);
    EXPECT_EQ(request.method, "GET");
    EXPECT_EQ(request.path, "/a b");
    EXPECT_EQ(request.host, "Example:80");
    EXPECT_EQ(request.header("x-a"), "b");
    EXPECT_TRUE(request.lists("connection", "upgrade"));
    EXPECT_FALSE(request.lists("connection", "up"));
    EXPECT_TRUE(request.keepAlive);
}

TEST(HttpHead, AnAbsoluteTargetNamesTheHost) {
    const HttpHead head = readHttpHead("GET http://evil.example/healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
    EXPECT_EQ(std::get<HttpRequest>(head.what).host, "evil.example");
    EXPECT_EQ(std::get<HttpRequest>(head.what).path, "/healthz");
}

TEST(HttpHead, IsIncompleteUntilItsLastByte) {
    const std::string text = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
    for (size_t n = 0; n < text.size(); n++) {
        const HttpHead head = readHttpHead(text.substr(0, n));
        EXPECT_EQ(head.bytes, 0u) << n;
        EXPECT_TRUE(std::holds_alternative<std::monostate>(head.what)) << n;
    }
    EXPECT_EQ(readHttpHead(text).bytes, text.size());
}

TEST(HttpHead, RefusesWhatTwoReadersCouldTakeDifferently) {
    const std::string host = "Host: x\r\n";
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n\r\n"), 400u);                                          // no Host
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + host + "\r\n"), 400u);                       // two
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\nHost:\r\n\r\n"), 400u);                                 // empty
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\nHost: a b\r\n\r\n"), 400u);                             // no name
    EXPECT_EQ(faultOf("GET / HTTP/1.1\n" + host + "\n"), 400u);                                  // bare line feeds
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + "A: b\r\n c\r\n\r\n"), 400u);                // folded
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + "A : b\r\n\r\n"), 400u);                     // space before colon
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + std::string("A: b\0c\r\n\r\n", 11)), 400u);  // control character
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + "Content-Length: -5\r\n\r\n"), 400u);
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + "Content-Length: 0\r\nContent-Length: 7\r\n\r\n"), 400u);
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + "Content-Length: 5\r\n\r\n"), 413u);
    EXPECT_EQ(faultOf("GET / HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\n\r\n"), 413u);
    EXPECT_EQ(faultOf("GET /% HTTP/1.1\r\n" + host + "\r\n"), 400u);
    EXPECT_EQ(faultOf("GET * HTTP/1.1\r\n" + host + "\r\n"), 400u);
    EXPECT_EQ(faultOf("GET /a b HTTP/1.1\r\n" + host + "\r\n"), 400u);
    EXPECT_EQ(faultOf("GET /healthz\r\n"), 400u);
    EXPECT_EQ(faultOf(std::string("\x16\x03\x01\x02", 4)), 400u);  // TLS, told before a line has come
    EXPECT_EQ(faultOf("GET / HTTP/9.9\r\n" + host + "\r\n"), 505u);
    EXPECT_EQ(faultOf("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"), 505u);
    EXPECT_EQ(faultOf("GET / HTTP/1.0\r\n\r\n"), 0u);  // has no need of a Host
}

TEST(HttpHead, IsBounded) {
    const std::string get = "GET / HTTP/1.1\r\nHost: x\r\n";
    EXPECT_EQ(faultOf("GET /" + std::string(REQUEST_TARGET_LIMIT, 'a') + " HTTP/1.1\r\nHost: x\r\n\r\n"), 414u);
    EXPECT_EQ(faultOf("GET /" + std::string(2 * REQUEST_TARGET_LIMIT, 'a')), 414u);  // before its end has come
    EXPECT_EQ(faultOf(get + "X-a: " + std::string(REQUEST_HEAD_LIMIT, 'y')), 431u);
    std::string many = get;
    for (size_t i = 0; i < REQUEST_HEADERS_LIMIT; i++) many += "X: y\r\n";
    EXPECT_EQ(faultOf(many + "\r\n"), 431u);
    EXPECT_EQ(faultOf(get + "Cookie: " + std::string(8000, 'y') + "\r\n\r\n"), 0u);
}

std::string clientFrame(unsigned first, const std::string& payload, bool masked = true) {
    std::string frame(1, static_cast<char>(first));
    const size_t n = payload.size();
    const char mask = masked ? '\x80' : '\0';
    if (n < 126) frame += static_cast<char>(mask | static_cast<char>(n));
    else frame += {static_cast<char>(mask | 126), static_cast<char>(n >> 8), static_cast<char>(n)};
    const char key[] = {0x11, 0x22, 0x33, 0x44};
    if (masked) frame.append(key, 4);
    for (size_t i = 0; i < n; i++) frame += static_cast<char>(payload[i] ^ (masked ? key[i % 4] : 0));
    return frame;
}

/// What a reader makes of the bytes when they come `step` at a time: messages, control frames, and the fault's code.
std::string readAll(std::string bytes, size_t step) {
    FrameReader reader;
    std::string told, arrived;
    for (size_t at = 0; at < bytes.size(); at += step) {
        arrived += bytes.substr(at, step);
        std::span<uint8_t> span(reinterpret_cast<uint8_t*>(arrived.data()), arrived.size());
        while (true) {
            auto next = reader.next(span);
            if (auto* fault = std::get_if<FrameFault>(&next)) return told + "!" + std::to_string(fault->code);
            auto* piece = std::get_if<FrameReader::Piece>(&next);
            if (!piece) break;
            if (static_cast<int>(piece->opcode) >= 8) told += "<" + std::to_string(static_cast<int>(piece->opcode)) + ":";
            told.append(reinterpret_cast<const char*>(piece->bytes.data()), piece->bytes.size());
            if (static_cast<int>(piece->opcode) >= 8) told += ">";
            else if (piece->ends) told += piece->last ? "." : ",";
        }
        arrived.erase(0, arrived.size() - span.size());
    }
    return told;
}

TEST(Frames, AreTheSameInAnyPieces) {
    const std::string bytes = clientFrame(0x01, "ab") + clientFrame(0x89, "ping") + clientFrame(0x00, "") +
                              clientFrame(0x80, "cd") + clientFrame(0x82, std::string(300, 'z')) + clientFrame(0x8a, "") +
                              clientFrame(0x81, "");
    const std::string told = "ab,<9:ping>,cd." + std::string(300, 'z') + ".<10:>.";
    for (size_t step : {1u, 2u, 3u, 7u, 64u, 1000u}) EXPECT_EQ(readAll(bytes, step), told) << step;
}

TEST(Frames, BreakingTheRulesIsAFault) {
    EXPECT_EQ(readAll(clientFrame(0x81, "x", false), 100), "!1002");  // unmasked
    EXPECT_EQ(readAll(clientFrame(0xc1, "x"), 100), "!1002");         // reserved bits
    EXPECT_EQ(readAll(clientFrame(0x91, "x"), 100), "!1002");
    EXPECT_EQ(readAll(clientFrame(0x83, "x"), 100), "!1002");  // unknown opcodes
    EXPECT_EQ(readAll(clientFrame(0x8b, "x"), 100), "!1002");
    EXPECT_EQ(readAll(clientFrame(0x09, "x"), 100), "!1002");  // a ping in fragments
    EXPECT_EQ(readAll(clientFrame(0x89, std::string(126, 'x')), 200), "!1002");
    EXPECT_EQ(readAll(clientFrame(0x80, "x"), 100), "!1002");  // continues nothing
    EXPECT_EQ(readAll(clientFrame(0x01, "a") + clientFrame(0x81, "b"), 100), "a,!1002");
    EXPECT_EQ(readAll(std::string("\x81\xfe\x00\x05", 4) + std::string(9, 'x'), 100), "!1002");  // 5 in two bytes
    EXPECT_EQ(readAll(std::string("\x81\xff\x80\0\0\0\0\0\0\0", 10) + std::string(9, 'x'), 100), "!1002");
}

TEST(Frames, TextIsUtf8) {
    for (const char* good : {"\xc3\xa4", "\xe2\x82\xac", "\xf0\x9f\x98\x80", "\xed\x9f\xbf", "\xf4\x8f\xbf\xbf"})
        EXPECT_EQ(readAll(clientFrame(0x81, good), 1), std::string(good) + ".") << good;
    for (const char* bad :
         {"\xff", "\xc0\xaf", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xc3", "\x80", "\xf5\x80\x80\x80"})
        EXPECT_EQ(readAll(clientFrame(0x81, bad), 100), "!1007") << bad;
    EXPECT_EQ(readAll(clientFrame(0x01, "\xc3") + clientFrame(0x80, "\xa4"), 100), "\xc3,\xa4.");  // halves in two fragments
    EXPECT_EQ(readAll(clientFrame(0x82, "\xff"), 100), "\xff.");
}

TEST(Frames, NoBytesBreakTheReader) {
    std::mt19937 random(7);
    int faults = 0;
    // Where a fault is found, less or more of the text before it may have been told.
    auto outcome = [](const std::string& told) {
        const size_t fault = told.rfind("!100");
        return fault == told.npos ? told : told.substr(fault);
    };
    for (int round = 0; round < 20'000; round++) {
        std::string bytes = clientFrame(0x01, "hello") + clientFrame(0x89, "p") + clientFrame(0x80, std::string(200, 'x'));
        for (int i = 0; i < 3; i++) bytes[random() % bytes.size()] = static_cast<char>(random());
        const std::string whole = outcome(readAll(bytes, bytes.size()));
        faults += whole.starts_with('!');
        ASSERT_EQ(whole, outcome(readAll(bytes, 1 + random() % 9))) << round;
    }
    EXPECT_GT(faults, 1000);
}

TEST(Frames, CloseCodesAreThoseOfTheTable) {
    auto codeOf = [](const std::string& payload) {
        auto read = readClose({reinterpret_cast<const uint8_t*>(payload.data()), payload.size()});
        auto* words = std::get_if<CloseWords>(&read);
        return words ? static_cast<int>(words->code) : -static_cast<int>(std::get<FrameFault>(read).code);
    };
    EXPECT_EQ(codeOf(""), 1005);
    EXPECT_EQ(codeOf("\x03\xe8 bye"), 1000);
    EXPECT_EQ(codeOf("\x0f\xa8"), 4008);
    EXPECT_EQ(codeOf("\x03"), -1002);
    EXPECT_EQ(codeOf("\x03\xed"), -1002);  // 1005 is never sent
    EXPECT_EQ(codeOf("\x13\x88"), -1002);  // 5000
    EXPECT_EQ(codeOf("\x03\xe8\xff"), -1007);
}

TEST(Frames, HeadsAreWrittenInTheirShortestForm) {
    uint8_t bytes[16];
    auto head = [&](uint64_t length) {
        const uint8_t* begin = writeFrameHead(bytes + 16, Opcode::binary, true, length);
        return std::string(begin, static_cast<const uint8_t*>(bytes + 16));
    };
    EXPECT_EQ(head(125), "\x82\x7d");
    EXPECT_EQ(head(126), std::string("\x82\x7e\x00\x7e", 4));
    EXPECT_EQ(head(65536), std::string("\x82\x7f\0\0\0\0\0\1\0\0", 10));
    EXPECT_EQ(acceptOf("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");  // RFC 6455, 1.3
}

TEST(Upgrade, FollowsRfc6455) {
    auto statusOf = [](const std::string& line, const std::string& headers) {
        const HttpHead head = readHttpHead(line + "\r\nHost: x\r\nUpgrade: websocket\r\n" + headers + "\r\n");
        const auto fault = upgradeFault(std::get<HttpRequest>(head.what));
        return fault ? fault->status : 101u;
    };
    const std::string line = "GET /ws HTTP/1.1", connection = "Connection: Upgrade\r\n",
                      version = "Sec-WebSocket-Version: 13\r\n", key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    EXPECT_EQ(statusOf(line, connection + version + key), 101u);
    EXPECT_EQ(statusOf(line, connection + "Sec-WebSocket-Version: 8\r\n" + key), 426u);
    EXPECT_EQ(statusOf(line, connection + key), 426u);
    EXPECT_EQ(statusOf(line, version + key), 426u);
    EXPECT_EQ(statusOf(line, connection + version), 400u);
    EXPECT_EQ(statusOf(line, connection + version + "Sec-WebSocket-Key: abc\r\n"), 400u);
    EXPECT_EQ(statusOf("POST /ws HTTP/1.1", connection + version + key), 405u);
    EXPECT_EQ(statusOf("GET /other HTTP/1.1", connection + version + key), 404u);
    EXPECT_THAT(headOf(refusal(426, "x"), false), HasSubstr("\r\nsec-websocket-version: 13\r\n"));
}

TEST(Refusals, CarryWhatTheReaderNeeds) {
    for (unsigned status : {400u, 401u, 403u, 404u, 405u, 408u, 413u, 414u, 421u, 426u, 429u, 431u, 503u, 505u}) {
        const std::string head = headOf(refusal(status, "why", status == 503 || status == 429 ? 7 : 0), false);
        EXPECT_THAT(head, HasSubstr("\r\ncontent-security-policy: default-src 'self'")) << status;
        EXPECT_THAT(head, HasSubstr("\r\nx-content-type-options: nosniff\r\n")) << status;
        EXPECT_THAT(head, HasSubstr("\r\nconnection: close\r\n")) << status;
        EXPECT_EQ(head.find(" Answer\r\n"), head.npos) << status << " has words of its own";
        EXPECT_EQ(head.find("\r\nwww-authenticate: Bearer") != head.npos, status == 401) << status;
        EXPECT_EQ(head.find("\r\nretry-after: 7\r\n") != head.npos, status == 503 || status == 429) << status;
    }
}

TEST(TokenGuard, LocksAnAddressLongerEachTime) {
    TokenGuard guard;
    double now = 100.0, before = 0.0;
    for (int i = 0; i < FREE_GUESSES; i++, now += 1.0) {
        const double delay = guard.wrong("a", now);
        EXPECT_GT(delay, before);
        before = delay;
        EXPECT_EQ(guard.lockedFor("a", now), 0.0) << i;
    }
    for (double wait = 1.0; wait < 1000.0; wait *= 2.0) {
        guard.wrong("a", now);
        EXPECT_EQ(guard.lockedFor("a", now), std::min(wait, 300.0));
        now += std::min(wait, 300.0);
        EXPECT_EQ(guard.lockedFor("a", now), 0.0);
    }
    EXPECT_EQ(guard.lockedFor("b", now), 0.0);
    guard.right("a");
    guard.wrong("a", now);
    EXPECT_EQ(guard.lockedFor("a", now), 0.0);
}

TEST(TokenGuard, ForgetsAfterQuiet) {
    TokenGuard guard;
    for (int i = 0; i <= FREE_GUESSES; i++) guard.wrong("a", 0.0);
    EXPECT_GT(guard.lockedFor("a", 0.5), 0.0);
    guard.wrong("b", 2000.0);
    guard.wrong("a", 2000.0);
    EXPECT_EQ(guard.lockedFor("a", 2000.0), 0.0);
}

TEST(Admission, TheOldestIdleConnectionGivesWay) {
    const Waiting all[] = {{1, "a", true, 1.0}, {2, "a", false, 5.0}, {3, "b", false, 3.0}, {4, "c", false, 9.0}};
    EXPECT_EQ(whoGivesWay(all, ""), 3u);
    EXPECT_EQ(whoGivesWay(all, "a"), 2u);
    EXPECT_EQ(whoGivesWay(std::span(all, 1), ""), 1u);
    EXPECT_EQ(whoGivesWay(all, "d"), std::nullopt);
}

TEST(Admission, AnAddressThatFillsThePoolOfGuestsPushesOutItsOwn) {
    const Waiting all[] = {
        {1, "honest", false, 1.0}, {2, "many", false, 5.0}, {3, "many", false, 3.0}, {4, "many", false, 9.0}};
    EXPECT_EQ(whichGuestLeaves(all), 3u);
    EXPECT_EQ(whichGuestLeaves({}), std::nullopt);
}

}  // namespace
}  // namespace heliograph

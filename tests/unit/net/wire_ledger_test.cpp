#include "server/net/guard/wire_ledger.h"

#include "server/net/guard/tcp_counts.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>

namespace heliograph::TEST_FILE {
namespace {

using Wire = WireLedger::Wire;

constexpr uint64_t HEAD = 400;  // bytes of the request that opened the WebSocket

TEST(WireLedger, MaskedFramesOfEachHeaderAreNoFault) {
    WireLedger ledger(Wire::plain, HEAD);
    uint64_t consumed = HEAD;
    for (auto [payload, header] : {std::pair(0u, 6u), {125u, 6u}, {126u, 8u}, {65535u, 8u}, {65536u, 14u}}) {
        consumed += payload + header;
        ledger.delivered(payload, 0);
        EXPECT_FALSE(ledger.unmasked(consumed)) << payload;
        EXPECT_TRUE(ledger.unmasked(consumed - 1)) << payload;
        EXPECT_EQ(ledger.unaccounted(consumed), 0.0) << payload;
    }
}

TEST(WireLedger, AFrameInPiecesHasOneHeader) {
    WireLedger ledger(Wire::plain, HEAD);
    ledger.delivered(100, 200);
    EXPECT_FALSE(ledger.unmasked(HEAD + 108));
    ledger.delivered(150, 50);
    ledger.delivered(50, 0);
    EXPECT_FALSE(ledger.unmasked(HEAD + 308));
    ledger.delivered(10, 0);
    EXPECT_TRUE(ledger.unmasked(HEAD + 308 + 10 + 2)) << "two bytes of a header: without the mask";
}

TEST(WireLedger, OverTlsTheRecordsTellOfMasks) {
    WireLedger ledger(Wire::tls, HEAD);
    ledger.delivered(1000, 0);
    EXPECT_FALSE(ledger.unmasked(HEAD));
    EXPECT_FALSE(ledger.unmaskedInRecords(1008));
    EXPECT_TRUE(ledger.unmaskedInRecords(1004)) << "four bytes fewer: without the mask";
}

TEST(WireLedger, PingsAreChargedAsMessages) {
    WireLedger ledger(Wire::plain, HEAD);
    const uint64_t flood = 6 * 100'000;
    const double first = ledger.unaccounted(HEAD + flood);
    EXPECT_GT(first, 97'000);
    EXPECT_LE(first, 100'000);
    EXPECT_DOUBLE_EQ(ledger.unaccounted(HEAD + flood + 600), 100.0) << "nothing is held twice";
    EXPECT_EQ(ledger.unaccounted(HEAD + flood + 600), 0.0);
}

TEST(WireLedger, WhatIsReadButNotDeliveredYetIsNotCharged) {
    WireLedger ledger(Wire::plain, HEAD);
    EXPECT_EQ(ledger.unaccounted(HEAD + 16384), 0.0);
    ledger.delivered(16384 - 8, 0);
    EXPECT_EQ(ledger.unaccounted(HEAD + 16384), 0.0);
    EXPECT_EQ(ledger.unaccounted(HEAD + 2 * 16384), 0.0);
}

TEST(WireLedger, AnHourOfAcknowledgementsGivesNoCredit) {
    for (Wire wire : {Wire::plain, Wire::tls}) {
        WireLedger ledger(wire, HEAD);
        const uint64_t payload = 48, records = wire == Wire::tls ? 22 : 0;
        uint64_t consumed = HEAD;
        for (int second = 0; second < 3600; second++) {
            for (int i = 0; i < 60; i++) {
                ledger.delivered(payload, 0);
                consumed += payload + 6 + records;
            }
            if (second % 15 == 0) consumed += 6 + records;  // it answers a ping
            EXPECT_EQ(ledger.unaccounted(consumed), 0.0) << second;
        }
        EXPECT_GT(ledger.unaccounted(consumed + 6 * 20'000), 10'000) << "a flood after it is charged all the same";
    }
}

/// Two ends of a TCP connection over loopback.
std::array<int, 2> connected() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    const int listener = socket(AF_INET, SOCK_STREAM, 0), client = socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(listener, 1), 0);
    EXPECT_EQ(getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
    EXPECT_EQ(connect(client, reinterpret_cast<sockaddr*>(&address), size), 0);
    const int server = accept(listener, nullptr, nullptr);
    ::close(listener);
    return {client, server};
}

TEST(TcpCounts, ConsumedIsWhatWasReadNotWhatWaits) {
    const auto [client, server] = connected();
    EXPECT_EQ(consumedBytes(server), 0u);
    const std::string bytes(1000, 'x');
    ASSERT_EQ(send(client, bytes.data(), bytes.size(), 0), 1000);
    char read[300];
    ASSERT_EQ(recv(server, read, sizeof read, MSG_WAITALL), 300);
    EXPECT_EQ(consumedBytes(server), 300u);
    ::close(client);
    ::close(server);
}

TEST(TcpCounts, NothingIsSaidOfOtherSockets) {
    int pair[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, pair), 0);
    EXPECT_EQ(consumedBytes(pair[0]), std::nullopt);
    EXPECT_EQ(acknowledgedBytes(pair[0]), 0u);
    ::close(pair[0]);
    ::close(pair[1]);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

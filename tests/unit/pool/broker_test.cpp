#include "server/pool/broker.h"

#include "server/base/error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace heliograph::TEST_FILE {
namespace {

TEST(Broker, AddressesAreReadAndWritten) {
    const std::vector<BrokerAddress> brokers = parseBrokers("nats://a.example:4222,tls://[::1]:5000,nats://b");
    ASSERT_EQ(brokers.size(), 3u);
    EXPECT_EQ(urlOf(brokers[0]), "nats://a.example:4222");
    EXPECT_EQ(urlOf(brokers[1]), "tls://[::1]:5000");
    EXPECT_TRUE(brokers[1].tls);
    EXPECT_EQ(urlOf(brokers[2]), "nats://b:4222");
}

TEST(Broker, WhatIsNoAddressIsRefused) {
    for (const char* text :
         {"", "a.example:4222", "http://a:1", "nats://", "nats://:4222", "nats://a:0", "nats://a:70000", "nats://a:12x",
          "nats://[::1:5", "nats://[::1]5", "nats://user:secret@a:4222", "nats://a,,nats://b"})
        EXPECT_THROW(parseBrokers(text), InputError) << text;
}

TEST(Broker, AGreetingSaysWhetherItAsksWhoComes) {
    EXPECT_EQ(asksWhoComes(R"(INFO {"version":"2.9.10","auth_required":true})"), true);
    EXPECT_EQ(asksWhoComes(R"(INFO {"version":"2.9.10","tls_required":true,"tls_verify":true})"), true);
    EXPECT_EQ(asksWhoComes(R"(INFO {"version":"2.9.10"})"), false);
    EXPECT_EQ(asksWhoComes("HTTP/1.1 400 Bad Request"), std::nullopt);
    EXPECT_EQ(asksWhoComes("INFO {"), std::nullopt);
    EXPECT_EQ(asksWhoComes(""), std::nullopt);
}

TEST(Broker, AnotherMachineHasToAskWhoComes) {
    BrokerOptions options;
    options.url = "nats://broker.invalid:4222";
    EXPECT_THROW(checkBrokers(options, parseBrokers(options.url)), InputError);
    options.insecure = true;
    EXPECT_NO_THROW(checkBrokers(options, parseBrokers(options.url)));
    options.insecure = false;
    options.url = "nats://127.0.0.1:4222,nats://localhost:4222,nats://[::1]:4222";
    EXPECT_NO_THROW(checkBrokers(options, parseBrokers(options.url)));
}

TEST(Broker, ASecretIsAUserWithAPasswordOrAToken) {
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "pool.secret";
    std::ofstream(path) << "pool:a long secret: with colons\nmore\n";
    EXPECT_EQ(readBrokerSecret(path).user, "pool");
    EXPECT_EQ(readBrokerSecret(path).password, "a long secret: with colons");
    std::ofstream(path) << "0123456789abcdef\n";
    EXPECT_EQ(readBrokerSecret(path).token, "0123456789abcdef");
    EXPECT_THROW(readBrokerSecret(path.string() + ".none"), InputError);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

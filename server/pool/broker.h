#pragma once
// Where a pool's broker is and how one gets in.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace heliograph {

struct BrokerOptions {
    std::string url;               // "nats://host:4222" or "tls://host:4222"; several of a cluster with commas between
    std::string secretFile;        // first line: USER:PASSWORD, or a token; empty: none
    std::string caFile;            // that signed the broker's certificate; empty: the system's
    std::string certificate, key;  // of this machine, for a broker that asks; empty: none
    bool insecure = false;         // a broker of another machine may let everybody in
};

struct BrokerAddress {
    std::string host;  // without brackets
    uint16_t port = 4222;
    bool tls = false;
};

/// Throws InputError for what is no such address. Secrets do not belong there: everybody sees a command line.
std::vector<BrokerAddress> parseBrokers(const std::string& url);
/// What cnats takes: "nats://host:4222".
std::string urlOf(const BrokerAddress& address);

/// What a broker's greeting ("INFO {...}") says: whether it asks who comes. Nothing where it is no greeting of NATS.
std::optional<bool> asksWhoComes(const std::string& greeting);
/// The greeting of the broker at that address; empty where none is to be had within a second.
std::string brokerGreeting(const BrokerAddress& address);

/// Throws InputError where a broker on another machine would be used that lets everybody in, unless the options allow it: who
/// reaches it could read scenes and make pixels.
void checkBrokers(const BrokerOptions& options, const std::vector<BrokerAddress>& brokers);

struct BrokerSecret {
    std::string user, password, token;
};
/// Of the file. Throws InputError.
BrokerSecret readBrokerSecret(const std::string& path);

}  // namespace heliograph

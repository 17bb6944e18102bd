#include "server/app/pool_devices.h"

#include "server/app/devices.h"
#include "server/base/clock.h"
#include "server/device/remote/remote_device.h"
#include "server/pool/nats_transport.h"
#include "server/request/device_rows.h"

#include <CLI/CLI.hpp>

#include <charconv>
#include <thread>

namespace heliograph {

namespace {

using namespace std::chrono_literals;

constexpr double NODE_PATIENCE = 10.0;  // seconds
constexpr auto NODE_LOOK = 20ms;

bool isNode(std::string_view name) { return name.starts_with(device_name::node) && name.find(':') == device_name::node.size(); }

uint32_t numberIn(std::string_view name) {
    uint32_t number = 0;
    name.remove_prefix(device_name::node.size() + 1);
    std::from_chars(name.data(), name.data() + name.size(), number);
    return number;
}

}  // namespace

void addPoolOptions(CLI::App& command, BrokerOptions& broker, bool isRequired) {
    command
        .add_option("--pool", broker.url,
                    "The pool's NATS broker, as nats://HOST:4222 or tls://HOST:4222; several of a\ncluster with commas between")
        ->required(isRequired)
        ->type_name("URL");
    command
        .add_option("--pool-secret", broker.secretFile, "File whose first line is USER:PASSWORD or the token for the broker")
        ->type_name("FILE");
    command.add_option("--pool-ca", broker.caFile, "Certificate of who signed the broker's (PEM); else those of the system")
        ->type_name("FILE");
    CLI::Option* key = command.add_option("--pool-key", broker.key, "Key of --pool-cert (PEM)")->type_name("FILE");
    CLI::Option* certificate =
        command.add_option("--pool-cert", broker.certificate, "Certificate of this machine for the broker (PEM)")
            ->type_name("FILE");
    key->needs(certificate);
    certificate->needs(key);
    command.add_flag("--pool-insecure", broker.insecure, "Use a broker on another machine that lets everybody in");
}

std::unique_ptr<Renderer> makePoolRenderer(const BrokerOptions& broker, uint32_t nodes) {
    const std::shared_ptr<PoolHead> pool = joinPool(broker);
    const StopWatch watch;
    while (pool->nodes().size() < nodes && watch.seconds() < NODE_PATIENCE) std::this_thread::sleep_for(NODE_LOOK);
    if (pool->nodes().size() < nodes)
        throw std::runtime_error("--pool-nodes: " + std::to_string(pool->nodes().size()) + " of " + std::to_string(nodes) +
                                 " nodes came within 10 s");
    return makeRenderer(withPool(deviceOffer(), pool));
}

std::shared_ptr<PoolHead> joinPool(const BrokerOptions& broker) {
    return std::make_shared<PoolHead>(makeNatsTransport(broker, "heliograph head"), buildDigest());
}

nlohmann::ordered_json poolJson(const PoolHead& pool) {
    nlohmann::ordered_json nodes = nlohmann::ordered_json::array();
    for (const PoolNode& node : pool.report()) {
        const bool isMeasured = node.seconds > 0.0;
        nodes.push_back({{"device", node.refused.empty() ? numberedDevice(device_name::node, node.number) : ""},
                         {"name", node.name},
                         {"hardware", node.hardware},
                         {"state", node.state},
                         {"refused", node.refused},
                         {"roundTripMs", 1e3 * node.roundTrip},
                         {"mraysPerSecond", isMeasured ? 1e-6 * static_cast<double>(node.rays) / node.seconds : 0.0},
                         {"tiles", node.tiles}});
    }
    return {{"broker", pool.peer()}, {"connected", pool.connected()}, {"nodes", nodes}};
}

PoolState poolState(const PoolHead& pool) {
    PoolState state;
    state.connected = pool.connected();
    for (const PoolNode& node : pool.report()) {
        (node.refused.empty() ? state.nodes : state.refusedNodes)++;
        if (node.seconds > 0.0) state.raysPerSecond += static_cast<double>(node.rays) / node.seconds;
    }
    const PoolCounts& counts = pool.counts();
    state.tiles = counts.tiles;
    state.batches = counts.batches;
    state.lostBatches = counts.lost;
    state.receivedBytes = counts.received;
    state.sentBytes = counts.sent;
    state.unsoundMessages = counts.unsound;
    state.lateMessages = counts.late;
    return state;
}

DeviceOffer withPool(DeviceOffer offer, std::shared_ptr<PoolHead> pool) {
    const auto local = offer.nameOf;
    offer.own = local(Settings());
    if (offer.own == "hybrid") offer.own = offer.fallback;
    offer.words.insert(offer.words.end() - (offer.words.back() == "hybrid" ? 1 : 0), std::string(POOL));
    offer.nodes = [pool] {
        std::vector<std::string> names;
        for (uint32_t number : pool->nodes()) names.push_back(numberedDevice(device_name::node, number));
        return names;
    };
    offer.nameOf = [local](const Settings& settings) {
        const std::string word = Settings::choiceWord("device", settings.device);
        if (word == "auto") return std::string(POOLED);
        return word == POOL ? std::string(POOL) : local(settings);
    };
    offer.make = [pool, make = offer.make](const std::string& name) -> std::unique_ptr<Device> {
        return isNode(name) ? makeRemoteDevice(pool, numberIn(name)) : make(name);
    };
    return offer;
}

}  // namespace heliograph

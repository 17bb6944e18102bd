#pragma once
// The nodes of a pool among the devices that viewers choose between.

#include "server/pool/broker.h"
#include "server/operations/metrics_text.h"
#include "server/pool/head.h"
#include "server/render/device_set.h"

#include <nlohmann/json.hpp>

namespace CLI {
class App;
}

namespace heliograph {

/// Adds --pool and what goes with it.
void addPoolOptions(CLI::App& command, BrokerOptions& broker, bool isRequired);

/// This process as a head of the pool. Throws InputError.
std::shared_ptr<PoolHead> joinPool(const BrokerOptions& broker);
/// A renderer with the nodes that are there once there are so many; waits for their scenes. Throws std::runtime_error when fewer
/// come within ten seconds.
std::unique_ptr<Renderer> makePoolRenderer(const BrokerOptions& broker, uint32_t nodes);
/// {broker, connected, nodes: [{device, name, hardware, state, refused, roundTripMs, mraysPerSecond, tiles}]}
nlohmann::ordered_json poolJson(const PoolHead& pool);
/// For /metrics.
PoolState poolState(const PoolHead& pool);
/// The offer with the pool's nodes: `pool` means them alone, `auto` this machine's own device and them, `hybrid` everything.
DeviceOffer withPool(DeviceOffer offer, std::shared_ptr<PoolHead> pool);

}  // namespace heliograph

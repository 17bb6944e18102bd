#pragma once
// The pool's messages over a NATS broker.

#include "server/pool/broker.h"
#include "server/pool/transport.h"

namespace heliograph {

/// `name`: of this program, as the broker lists it. A broker that is not there yet is waited for in the background, one that
/// goes too. Throws InputError for a wrong address, a secret that the broker refuses, or one that lets everybody in
/// (checkBrokers).
std::shared_ptr<Transport> makeNatsTransport(const BrokerOptions& options, const std::string& name);

}  // namespace heliograph

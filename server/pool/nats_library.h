#pragma once
// The NATS client library (nats.c), loaded when a pool is asked for: who has none loads nothing. Private to server/pool.

#include <nats/nats.h>

namespace heliograph {

// The functions that are used.
#define NATS_FUNCTIONS(FUNCTION)                    \
    FUNCTION(natsOptions_Create)                    \
    FUNCTION(natsOptions_Destroy)                   \
    FUNCTION(natsOptions_SetServers)                \
    FUNCTION(natsOptions_SetName)                   \
    FUNCTION(natsOptions_SetUserInfo)               \
    FUNCTION(natsOptions_SetToken)                  \
    FUNCTION(natsOptions_SetSecure)                 \
    FUNCTION(natsOptions_LoadCATrustedCertificates) \
    FUNCTION(natsOptions_LoadCertificatesChain)     \
    FUNCTION(natsOptions_SetSendAsap)               \
    FUNCTION(natsOptions_SetTimeout)                \
    FUNCTION(natsOptions_SetIOBufSize)              \
    FUNCTION(natsOptions_SetWriteDeadline)          \
    FUNCTION(natsOptions_SetPingInterval)           \
    FUNCTION(natsOptions_SetMaxPingsOut)            \
    FUNCTION(natsOptions_SetMaxReconnect)           \
    FUNCTION(natsOptions_SetReconnectWait)          \
    FUNCTION(natsOptions_SetReconnectJitter)        \
    FUNCTION(natsOptions_SetReconnectBufSize)       \
    FUNCTION(natsOptions_SetRetryOnFailedConnect)   \
    FUNCTION(natsOptions_SetDisconnectedCB)         \
    FUNCTION(natsOptions_SetReconnectedCB)          \
    FUNCTION(natsOptions_SetClosedCB)               \
    FUNCTION(natsOptions_SetErrorHandler)           \
    FUNCTION(natsConnection_Connect)                \
    FUNCTION(natsConnection_Close)                  \
    FUNCTION(natsConnection_Destroy)                \
    FUNCTION(natsConnection_Status)                 \
    FUNCTION(natsConnection_Publish)                \
    FUNCTION(natsConnection_PublishRequest)         \
    FUNCTION(natsConnection_Subscribe)              \
    FUNCTION(natsSubscription_SetPendingLimits)     \
    FUNCTION(natsSubscription_SetOnCompleteCB)      \
    FUNCTION(natsSubscription_Unsubscribe)          \
    FUNCTION(natsSubscription_Destroy)              \
    FUNCTION(natsMsg_IsNoResponders)                \
    FUNCTION(natsMsg_GetSubject)                    \
    FUNCTION(natsMsg_GetData)                       \
    FUNCTION(natsMsg_GetDataLength)                 \
    FUNCTION(natsMsg_Destroy)                       \
    FUNCTION(natsStatus_GetText)

struct NatsLibrary {
#define NATS_MEMBER(name) decltype(&::name) name = nullptr;
    NATS_FUNCTIONS(NATS_MEMBER)
#undef NATS_MEMBER
};

/// Throws InputError where it is not installed.
const NatsLibrary& natsLibrary();

}  // namespace heliograph

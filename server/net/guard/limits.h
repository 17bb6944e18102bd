#pragma once
// All limits of the wire, with what happens beyond them. docs/reference/protocol.md prints this table.

#include <chrono>
#include <cstddef>
#include <cstdint>

/// LIMIT(type, name, value, unit, of what; what happens beyond it)
#define WIRE_LIMITS(LIMIT)                                                                                                   \
    LIMIT(size_t, MESSAGE_LIMIT, 65536, "bytes", "a text message from a viewer; larger: close 1009")                         \
    LIMIT(uint64_t, MESSAGE_DEPTH, 16, "levels", "JSON nested in a message; deeper: `error`")                                \
    LIMIT(double, MESSAGE_RATE, 1000, "a second", "messages from a viewer; more for long: close 1008")                       \
    LIMIT(double, MESSAGE_BURST, 2000, "messages", "at once; more: close 1008")                                              \
    LIMIT(double, BYTE_RATE, 1048576, "bytes a second", "from a viewer; more for long: close 1008")                          \
    LIMIT(double, BYTE_BURST, 4194304, "bytes", "at once; more: close 1008")                                                 \
    LIMIT(size_t, ADDRESS_LIMIT, 8192, "bytes", "path and query of a request; longer: HTTP 414")                             \
    LIMIT(size_t, HEADERS_LIMIT, 16384, "bytes", "the headers of a request; longer: HTTP 431")                               \
    LIMIT(size_t, SCENE_NAME_LIMIT, 256, "bytes", "the name of a scene; longer: `error`")                                    \
    LIMIT(size_t, VIEW_ID_LIMIT, 64, "bytes", "the id of a view; longer: `error`")                                           \
    LIMIT(size_t, TOKEN_LIMIT, 4096, "bytes", "the token; longer: `error`")                                                  \
    LIMIT(uint64_t, MAX_PRESENTED_MS, 3600000, "ms", "`presentedMs` of an `ack`; more: `error`")                             \
    LIMIT(uint32_t, MIN_SIDE, 16, "pixels", "least width and height of a picture; less: `error`")                            \
    LIMIT(uint32_t, MAX_SIDE, 8192, "pixels", "largest width and height of a picture; more: `error`")                        \
    LIMIT(uint64_t, MAX_PIXELS, 33177600, "pixels", "of a picture (7680 x 4320); more: `error`")                             \
    LIMIT(uint32_t, MIN_SWEEP_SECONDS, 5, "seconds", "least `seconds` of `accuracy` but for 0; less: `error`")               \
    LIMIT(uint32_t, MAX_SWEEP_SECONDS, 600, "seconds", "most `seconds` of `accuracy`; more: `error`")                        \
    LIMIT(size_t, MAX_VIEWERS, 32, "viewers", "unless `--max-viewers` says otherwise; another one: HTTP 503")                \
    LIMIT(uint32_t, MAX_UNACKED, 32, "frames", "on their way to a viewer at most; fewer where the line holds fewer")         \
    LIMIT(size_t, PICTURES_WAITING, 2, "pictures", "that wait for a viewer who reads slowly; more: close 4008")              \
    LIMIT(size_t, TEXT_WAITING, 4194304, "bytes", "of text that wait for a viewer who reads slowly; more: close 4008")       \
    LIMIT(size_t, MAX_GUESTS, 32, "viewers", "that have not said the token yet; another one: the oldest goes, close 1013")   \
    LIMIT(size_t, SPARE_CONNECTIONS, 512, "connections", "beside the viewers; another one: the oldest idle one goes")        \
    LIMIT(size_t, SPARE_PER_ADDRESS, 256, "connections", "of one address beside the viewers; as above")                      \
    LIMIT(size_t, RESERVED_CONNECTIONS, 16, "connections", "where none is idle: `/healthz`, `/readyz`, `/metrics` alone")    \
    LIMIT(int, FREE_GUESSES, 10, "tokens", "wrong ones of an address, each answered later; more: 1 s locked out, doubling")  \
    LIMIT(std::chrono::seconds, LONGEST_LOCKOUT, 300, "seconds", "that an address is locked out for a wrong token")          \
    LIMIT(std::chrono::seconds, GUESS_MEMORY, 600, "seconds", "without a wrong token; longer: they are forgotten")           \
    LIMIT(std::chrono::seconds, TOKEN_WAIT, 5, "seconds", "for the token; longer: close 4001")                               \
    LIMIT(std::chrono::seconds, KEPT_VIEW, 60, "seconds", "that the view of who lost its line is kept; longer: it ends")     \
    LIMIT(size_t, KEPT_VIEWS, 8, "views", "that are kept so; another one, or no room for somebody: the oldest end")          \
    LIMIT(std::chrono::seconds, STALL_PAUSE, 2, "seconds", "without an acknowledgement; longer: nothing is rendered ahead")  \
    LIMIT(std::chrono::seconds, STALL_CLOSE, 10, "seconds", "without an acknowledgement; longer: close 4008")                \
    LIMIT(std::chrono::seconds, WRITE_WINDOW, 10, "seconds", "in which who is sent something takes 4,096 bytes; less: 4008") \
    LIMIT(std::chrono::seconds, CLOSE_WAIT, 2, "seconds", "until a close frame is out; longer: the connection is cut")       \
    LIMIT(std::chrono::seconds, IDLE_PING, 15, "seconds", "of silence; longer: the server pings")                            \
    LIMIT(std::chrono::seconds, IDLE_CLOSE, 30, "seconds", "of silence; longer: the server hangs up")

namespace heliograph {

#define LIMIT_CONSTANT(type, name, value, unit, what) constexpr type name{value};
WIRE_LIMITS(LIMIT_CONSTANT)
#undef LIMIT_CONSTANT

}  // namespace heliograph

#include "server/pool/nats_library.h"

#include "server/base/error.h"

#include <dlfcn.h>

namespace heliograph {

namespace {

NatsLibrary loadNats() {
    // Debian 12's, then whatever a newer system calls its own.
    void* library = nullptr;
    for (const char* name : {"libnats.so.3.4", "libnats.so"}) {
        if (!library) library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    }
    if (!library) throw InputError("--pool", "the NATS client library is not here", "install libnats3.4");
    NatsLibrary functions;
#define NATS_FIND(name)                                                          \
    functions.name = reinterpret_cast<decltype(&::name)>(dlsym(library, #name)); \
    if (!functions.name) throw InputError("--pool", "the NATS client library has no " #name, "version 3.4 or newer");
    NATS_FUNCTIONS(NATS_FIND)
#undef NATS_FIND
    return functions;
}

}  // namespace

const NatsLibrary& natsLibrary() {
    static const NatsLibrary library = loadNats();  // tried again if it throws
    return library;
}

}  // namespace heliograph

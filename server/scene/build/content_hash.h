#pragma once
// Names a scene by its content. Private to server/scene.

#include "server/scene/scene.h"

namespace heliograph {

/// 64-bit hash of every kernel array of the scene; the same for the same content however many threads compute it. Not
/// cryptographic. Word mixing after Zilong Tan's fasthash64.
uint64_t contentHashOf(const Scene& scene);

}  // namespace heliograph

#include "server/scene/build/content_hash.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>

namespace heliograph {

namespace {

constexpr uint64_t FACTOR = 0x880355f21e6d1965ull;
constexpr size_t CHUNK = size_t(1) << 20;  // bytes

uint64_t mix(uint64_t h) {
    h ^= h >> 23;
    h *= 0x2127599bf4325c37ull;
    return h ^ (h >> 47);
}

uint64_t combine(uint64_t hash, uint64_t word) { return (hash ^ mix(word)) * FACTOR; }

uint64_t hashChunk(const unsigned char* bytes, size_t length) {
    uint64_t hash = length * FACTOR;
    for (size_t at = 0; at < length; at += 8) {
        uint64_t word = 0;
        std::memcpy(&word, bytes + at, std::min<size_t>(8, length - at));
        hash = combine(hash, word);
    }
    return mix(hash);
}

uint64_t hashBytes(uint64_t hash, const void* data, size_t length) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    std::vector<uint64_t> parts((length + CHUNK - 1) / CHUNK);
    tbb::parallel_for(size_t(0), parts.size(),
                      [&](size_t i) { parts[i] = hashChunk(bytes + i * CHUNK, std::min(CHUNK, length - i * CHUNK)); });
    hash = combine(hash, length);
    for (uint64_t part : parts) hash = combine(hash, part);
    return hash;
}

template <typename T>
uint64_t hashArray(uint64_t hash, const std::vector<T>& array) {
    static_assert(std::is_trivially_copyable_v<T>);
    return hashBytes(hash, array.data(), array.size() * sizeof(T));
}

}  // namespace

uint64_t contentHashOf(const Scene& scene) {
    uint64_t hash = 0x48656c696f677270ull;
    hash = hashArray(hash, scene.positions);
    hash = hashArray(hash, scene.attributes);
    hash = hashArray(hash, scene.tangents);
    hash = hashArray(hash, scene.triangles);
    hash = hashArray(hash, scene.meshes);
    hash = hashArray(hash, scene.instances);
    hash = hashArray(hash, scene.materials);
    hash = hashArray(hash, scene.textures);
    hash = hashArray(hash, scene.images);
    hash = hashArray(hash, scene.imageLevels);
    hash = hashArray(hash, scene.texels);
    hash = hashArray(hash, scene.lights);
    hash = hashBytes(hash, &scene.environment, sizeof(Environment));
    hash = hashArray(hash, scene.offered);
    return mix(hash);
}

}  // namespace heliograph

#pragma once
// Memory in which one thread renders tiles: rays in packets, pending paths, occlusion work. Allocated once, reused for
// every tile.

#include "server/device/embree/ray_packet.h"
#include "shaders/kernel/kernel.h"

#include <vector>

namespace heliograph {

constexpr uint32_t BLOCK_LANES = 1024;  // pixels in work at once: a 32x32 block fits the second-level cache

/// Occlusion rays towards one light, packed without gaps in lane order.
struct ShadowQueue {
    std::vector<RTCRay16> packets;
    std::vector<uint16_t> lanes;
    std::vector<vec3> contributions;
    uint32_t count = 0;

    void reserve(uint32_t rays) {
        packets.resize((rays + PACKET - 1) / PACKET);
        lanes.resize(packets.size() * PACKET);
        contributions.resize(packets.size() * PACKET);
        count = 0;
    }
    void push(const Ray& ray, uint16_t lane, vec3 contribution) {
        setRay(packets[count / PACKET], count % PACKET, ray.origin, ray.direction, ray.tMax);
        lanes[count] = lane;
        contributions[count] = contribution;
        count++;
    }
};

/// Points that need ambient occlusion, structure of arrays: sixteen neighbours make a packet per sample.
struct OcclusionQueue {
    struct alignas(64) Group {
        float origin[3][PACKET];
        float normal[3][PACKET];
        float geometricNormal[3][PACKET];
        float tangent[3][PACKET];
        float bitangent[3][PACKET];
        uint32_t shift[PACKET];
        uint32_t visible[PACKET];
        uint16_t lane[PACKET];
        vec3 ambient[PACKET];
    };
    std::vector<Group> groups;
    uint32_t count = 0;
};

/// Paths waiting on the pixels' stacks, as linked lists in one pool.
template <typename Path>
struct PathStacks {
    static constexpr uint32_t END = 0xffffffffu;
    struct Entry { Path path; uint32_t below; };
    std::vector<Entry> pool;
    std::vector<uint32_t> free;
    uint32_t top[BLOCK_LANES];

    void clear(uint32_t lanes) {
        pool.clear();
        free.clear();
        for (uint32_t i = 0; i < lanes; i++) top[i] = END;
    }
    void push(uint32_t lane, const Path& path) {
        uint32_t index;
        if (free.empty()) {
            index = static_cast<uint32_t>(pool.size());
            pool.push_back({path, top[lane]});
        } else {
            index = free.back();
            free.pop_back();
            pool[index] = {path, top[lane]};
        }
        top[lane] = index;
    }
    bool pop(uint32_t lane, Path& path) {
        uint32_t index = top[lane];
        if (index == END) return false;
        path = pool[index].path;
        top[lane] = pool[index].below;
        free.push_back(index);
        return true;
    }
};

}  // namespace heliograph

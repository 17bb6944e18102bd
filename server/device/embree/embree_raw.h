#pragma once
// Bare Embree: the rays of a frame, made beforehand, loaded into packets, traced and counted. Nothing is shaded.

#include "server/device/embree/ray_packet.h"
#include "server/request/frame_request.h"
#include "server/film/tile.h"

#include <memory>

namespace heliograph {

struct BareTime {
    double wallMs = 0.0;
    double coreMs = 0.0;  // processor time of all threads
    uint64_t rays = 0;
};

class EmbreeRaw {
public:
    EmbreeRaw();
    ~EmbreeRaw();
    EmbreeRaw(const EmbreeRaw&) = delete;
    EmbreeRaw& operator=(const EmbreeRaw&) = delete;

    /// Makes the camera rays of the request's first sample, the shadow rays at their hits and, if the request has ambient
    /// occlusion, its rays; 4x4 pixels to a packet, the others packed without gaps.
    void prepare(std::shared_ptr<const Scene> scene, const FrameRequest& request);
    /// Traces one kind of the rays once, on all cores, in the widest native packets.
    BareTime trace(RayKind kind);

private:
    struct Data;
    std::unique_ptr<Data> data_;
};

}  // namespace heliograph

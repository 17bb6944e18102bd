#pragma once
// What a device's bare tracing costs: the same rays as a frame's, already made, packed as its library likes them best,
// nothing shaded. The yardstick for everything that a renderer adds.

#include "server/request/frame_request.h"

#include <memory>

namespace heliograph {

/// One kind of rays, traced once.
struct RawTime {
    double wallMs = 0.0;
    double coreMs = 0.0;  // processor time of all threads together
    uint64_t rays = 0;
};

struct RawTimes {
    RawTime primary;
    RawTime shadow;
    RawTime ambientOcclusion;
};

class RawBench {
public:
    virtual ~RawBench() = default;
    /// Makes the rays that `request` (with shadows and ambient occlusion on) leads to; the device keeps what it built
    /// for `scene`. Not measured.
    virtual void prepare(std::shared_ptr<const Scene> scene, const FrameRequest& request) = 0;
    /// Traces them once.
    virtual RawTimes measure() = 0;
};

}  // namespace heliograph

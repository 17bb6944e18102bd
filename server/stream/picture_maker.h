#pragma once
// From a film to the bytes of a picture file: develop, tone map, encode.

#include "server/encode/encoder.h"
#include "server/net/protocol.h"
#include "server/stream/frame_loop.h"

#include <memory>
#include <vector>

namespace heliograph {

struct MakingCosts {
    double developSeconds = 0.0;  // with the tone map
    double encodeSeconds = 0.0;
    double coreSeconds = 0.0;     // processor time of both
    double relativeError = 1.0;   // of the film
};

/// Keeps its buffers between pictures; one thread at a time.
class PictureMaker {
public:
    PictureMaker();
    ~PictureMaker();

    /// Appends the encoded picture to `front` bytes of any value; `bytes` is replaced. EXR holds the film's linear float
    /// values, the other formats what the viewer sees. Throws std::runtime_error.
    MakingCosts make(const FinishedFrame& frame, FrameCodec codec, uint32_t quality, size_t front,
                     std::vector<uint8_t>& bytes);

private:
    struct Encoders;
    std::unique_ptr<Encoders> encoders_;
    std::vector<vec4> pixels_;
    DisplayImage display_;
    std::vector<uint8_t> payload_;
};

}  // namespace heliograph

#pragma once
// From a film to the bytes that a viewer is sent: develop, tone map, encode, header.

#include "server/encode/encoder.h"
#include "server/net/viewer_socket.h"
#include "server/loop/finished_frame.h"

#include <memory>
#include <vector>

namespace heliograph {

/// A frame as it leaves, and what it cost.
struct EncodedFrame {
    OutgoingPicture picture;
    FrameHeader header;
    PassFigures figures;
    std::optional<PictureOrder> order;  // of a picture
    uint32_t targetSamples = 0;
    double coreSeconds = 0.0;  // processor time of developing and encoding
};

/// Keeps its buffers between pictures; one thread at a time.
class PictureMaker {
public:
    PictureMaker();
    ~PictureMaker();

    /// `header` says the codec, the quality and the frame's id; the rest is filled in. EXR holds the film's linear float values,
    /// the other formats what the viewer sees. Throws std::runtime_error.
    EncodedFrame make(const FinishedFrame& frame, FrameHeader header);

private:
    struct Encoders;
    std::unique_ptr<Encoders> encoders_;
    std::vector<vec4> pixels_;
    DisplayImage display_;
    std::vector<uint8_t> payload_;
};

}  // namespace heliograph

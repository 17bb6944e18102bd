#pragma once
// From a film to the bytes that a viewer is sent: develop, tone map, encode, header.

#include "server/encode/encoder.h"
#include "server/net/viewer_socket.h"
#include "server/loop/finished_frame.h"

#include <memory>
#include <vector>

namespace heliograph {

/// A picture as it is seen, kept to be sent in parts without loss.
struct StillPicture {
    DisplayImage image;
    FrameHeader header;  // of the frame that showed it first
};

/// A frame as it leaves, and what it cost.
struct EncodedFrame {
    OutgoingPicture picture;
    FrameHeader header;
    PassFigures figures;
    std::optional<PictureOrder> order;  // of a picture
    uint32_t targetSamples = 0;
    double coreSeconds = 0.0;                   // processor time of developing and encoding
    std::shared_ptr<const StillPicture> still;  // where it was to be kept
};

/// Keeps its buffers between pictures; one thread at a time.
class PictureMaker {
public:
    PictureMaker();
    ~PictureMaker();

    /// `header` says the codec, the quality and the frame's id; the rest is filled in. EXR holds the film's linear float values,
    /// the other formats what the viewer sees. Throws std::runtime_error.
    /// `keep`: the picture itself comes back too.
    EncodedFrame make(const FinishedFrame& frame, FrameHeader header, bool keep = false);
    /// The rows from `firstRow` on as PNG. `header`: its frame id alone counts, the rest is the picture's.
    EncodedFrame makePart(const StillPicture& still, uint32_t firstRow, uint32_t rows, FrameHeader header);

private:
    void finish(EncodedFrame& result, size_t placeBytes);

    struct Encoders;
    std::unique_ptr<Encoders> encoders_;
    std::vector<vec4> pixels_;
    DisplayImage display_;
    std::vector<uint8_t> payload_;
};

}  // namespace heliograph

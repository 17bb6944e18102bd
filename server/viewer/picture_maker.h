#pragma once
// From a film to the bytes that a viewer is sent: develop, tone map, encode, header.

#include "server/encode/encoder.h"
#include "server/net/viewer_socket.h"
#include "server/loop/finished_frame.h"
#include "server/base/made_once.h"

#include <compare>
#include <memory>
#include <vector>

namespace heliograph {

/// A picture as it is seen, kept to be sent in parts without loss.
struct StillPicture {
    struct Shared {
        DisplayImage image;
        bool several = false;                                    // several viewers may be sent it: its parts are kept
        mutable MadeOnce<uint32_t, std::vector<uint8_t>> parts;  // by their first row; all are of equally many rows
    };
    std::shared_ptr<const Shared> shared;
    FrameHeader header;  // of the frame that showed it first
};

/// What a picture is made for: viewers of one frame for whom all of it is equal are sent the same bytes.
struct PictureKey {
    FrameCodec codec = FrameCodec::jpeg;
    uint8_t quality = 0;
    bool keep = false;
    bool beginsVideo = false;
    auto operator<=>(const PictureKey&) const = default;
};
struct MadePicture {
    std::vector<uint8_t> payload;
    double developSeconds = 0.0;
    double encodeSeconds = 0.0;
    double helpSeconds = 0.0;  // processor time of other threads
    float relativeError = 1.0f;
    bool keyPicture = false;                            // of a video
    std::shared_ptr<const StillPicture::Shared> still;  // where it is kept
};
/// Of one frame.
using SharedPictures = MadeOnce<PictureKey, MadePicture>;

/// A frame as it leaves, and what it cost.
struct EncodedFrame {
    OutgoingPicture picture;
    FrameHeader header;
    PassFigures figures;
    std::optional<PictureOrder> order;  // of a picture
    uint32_t targetSamples = 0;
    ErrorForecast forecast;
    double refined = 1.0;                       // as FinishedFrame has it
    std::optional<float> autoExposure;          // the same
    std::optional<ErrorMap> errors;             // where it is asked for
    double coreSeconds = 0.0;                   // processor time of developing and encoding
    bool shared = false;                        // another viewer's thread has made it
    std::shared_ptr<const StillPicture> still;  // where it was to be kept
};

/// Keeps its buffers between pictures; one thread at a time.
class PictureMaker {
public:
    PictureMaker();
    ~PictureMaker();

    /// `header` says the codec, the quality, the frame's id, and by FRAME_KEY whether a video begins anew; the rest is filled in.
    /// EXR holds the film's linear float values, the other formats what the viewer sees. Throws std::runtime_error; a video
    /// begins anew then. `keep`: the picture itself comes back too. `shared`: of all who are sent this frame; may be null, and
    /// is of a video, which is one viewer's.
    EncodedFrame make(const FinishedFrame& frame, FrameHeader header, bool keep = false, SharedPictures* shared = nullptr);
    /// The rows from `firstRow` on as PNG. `header`: its frame id alone counts, the rest is the picture's.
    EncodedFrame makePart(const StillPicture& still, uint32_t firstRow, uint32_t rows, FrameHeader header);
    /// Lets go of its buffers, which the next picture makes anew. A video goes on.
    void rest();

private:
    void paint(const FinishedFrame& frame, const PictureKey& key, bool several, MadePicture& made);
    void encode(const FinishedFrame& frame, const PictureKey& key, MadePicture& made);
    void finish(EncodedFrame& result, std::span<const uint8_t> payload, size_t placeBytes);

    struct Encoders;
    std::unique_ptr<Encoders> encoders_;
    std::vector<vec4> pixels_;
    DisplayImage display_;
    MadePicture made_;
};

}  // namespace heliograph

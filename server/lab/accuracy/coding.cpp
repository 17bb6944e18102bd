#include "server/lab/accuracy/coding.h"

#include "server/base/clock.h"
#include "server/encode/jpeg_encoder.h"
#include "server/images/picture_reader.h"

namespace heliograph {

CodedPicture codedAsJpeg(const DisplayImage& image, uint32_t quality) {
    std::vector<uint8_t> bytes;
    const std::unique_ptr<Encoder> encoder = makeJpegEncoder();
    encoder->encode(image, quality, bytes);  // once unmeasured: memory is touched
    const StopWatch watch;
    encoder->encode(image, quality, bytes);
    CodedPicture coded{
        {image.width, image.height, std::vector<uint8_t>(image.rgba.size())}, bytes.size(), watch.milliseconds()};
    readJpeg(bytes, coded.image.rgba);
    return coded;
}

}  // namespace heliograph

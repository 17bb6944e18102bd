// The only file of this folder that sees OpenImageIO: its headers cost seconds to compile.
#include "server/encode/exr_encoder.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <stdexcept>

namespace heliograph {

void encodeExr(const std::vector<vec4>& pixels, uvec2 resolution, std::vector<uint8_t>& bytes) {
    namespace oiio = OIIO;
    auto output = oiio::ImageOutput::create("film.exr");
    if (output == nullptr) throw std::runtime_error("exr: " + oiio::geterror());
    oiio::Filesystem::IOVecOutput sink;
    if (!output->set_ioproxy(&sink)) throw std::runtime_error("exr: OpenImageIO cannot write to memory");
    oiio::ImageSpec spec(static_cast<int>(resolution.x), static_cast<int>(resolution.y), 3, oiio::TypeDesc::FLOAT);
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "linear");
    spec.attribute("DateTime", "1970:01:01 00:00:00");  // the same picture is the same file; left out, it would be now
    bool written = output->open("film.exr", spec) &&
                   output->write_image(oiio::TypeDesc::FLOAT, pixels.data(), sizeof(vec4),
                                       static_cast<oiio::stride_t>(sizeof(vec4)) * resolution.x) &&
                   output->close();
    if (!written) throw std::runtime_error("exr: " + output->geterror());
    bytes = sink.buffer();
}

}  // namespace heliograph

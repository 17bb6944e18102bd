#pragma once
// libvpx as a viewer has it.

#include "tests/support/waves.h"

#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <stdexcept>

namespace heliograph::test {

class Vp9Decoder {
public:
    Vp9Decoder() {
        if (vpx_codec_dec_init(&codec_, vpx_codec_vp9_dx(), nullptr, 0) != VPX_CODEC_OK) throw std::runtime_error("no libvpx");
    }
    ~Vp9Decoder() { vpx_codec_destroy(&codec_); }
    Vp9Decoder(const Vp9Decoder&) = delete;

    /// The picture that came out; its size is 0 where none did, or more than one, or one of other colours than BT.709's.
    YuvImage decode(const std::vector<uint8_t>& bytes) {
        YuvImage out;
        if (vpx_codec_decode(&codec_, bytes.data(), static_cast<unsigned int>(bytes.size()), nullptr, 0) != VPX_CODEC_OK)
            return out;
        vpx_codec_iter_t at = nullptr;
        const vpx_image_t* image = vpx_codec_get_frame(&codec_, &at);
        if (!image || image->cs != VPX_CS_BT_709 || image->range != VPX_CR_STUDIO_RANGE) return out;
        if (vpx_codec_get_frame(&codec_, &at) != nullptr) return out;
        out.width = image->d_w;
        out.height = image->d_h;
        out.y = planeOf(image->planes[0], image->stride[0], out.width, out.height);
        out.u = planeOf(image->planes[1], image->stride[1], out.colourWidth(), out.colourHeight());
        out.v = planeOf(image->planes[2], image->stride[2], out.colourWidth(), out.colourHeight());
        return out;
    }

private:
    vpx_codec_ctx_t codec_{};
};

}  // namespace heliograph::test

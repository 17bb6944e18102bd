#pragma once
// OpenH264's decoder, as a viewer may have it: without concealing what is missing. For builds with HELIOGRAPH_OPENH264.

#include "tests/support/waves.h"

#include <wels/codec_api.h>

#include <algorithm>
#include <stdexcept>

namespace heliograph::test {

class H264Decoder {
public:
    H264Decoder() {
        if (WelsCreateDecoder(&decoder_) != 0) throw std::runtime_error("no OpenH264");
        int level = WELS_LOG_QUIET;
        decoder_->SetOption(DECODER_OPTION_TRACE_LEVEL, &level);
        SDecodingParam settings{};
        settings.eEcActiveIdc = ERROR_CON_DISABLE;
        settings.sVideoProperty.eVideoBsType = VIDEO_BITSTREAM_AVC;
        if (decoder_->Initialize(&settings) != 0) throw std::runtime_error("OpenH264's decoder does not start");
    }
    ~H264Decoder() {
        decoder_->Uninitialize();
        WelsDestroyDecoder(decoder_);
    }
    H264Decoder(const H264Decoder&) = delete;

    /// The picture that came out, cut to that size as who shows it does; 0 x 0 where none did. `coded` says its size before.
    YuvImage decode(const std::vector<uint8_t>& bytes, uint32_t width, uint32_t height) {
        YuvImage out;
        unsigned char* planes[3] = {};
        SBufferInfo info{};
        codedWidth = codedHeight = 0;
        if (decoder_->DecodeFrameNoDelay(bytes.data(), static_cast<int>(bytes.size()), planes, &info) != dsErrorFree)
            return out;
        if (info.iBufferStatus != 1) return out;
        const SSysMEMBuffer& picture = info.UsrData.sSystemBuffer;
        codedWidth = static_cast<uint32_t>(picture.iWidth);
        codedHeight = static_cast<uint32_t>(picture.iHeight);
        if (codedWidth < width || codedHeight < height) return out;
        out.width = width;
        out.height = height;
        out.y = planeOf(planes[0], picture.iStride[0], width, height);
        out.u = planeOf(planes[1], picture.iStride[1], out.colourWidth(), out.colourHeight());
        out.v = planeOf(planes[2], picture.iStride[1], out.colourWidth(), out.colourHeight());
        return out;
    }

    uint32_t codedWidth = 0, codedHeight = 0;  // of the last picture

private:
    ISVCDecoder* decoder_ = nullptr;
};

}  // namespace heliograph::test

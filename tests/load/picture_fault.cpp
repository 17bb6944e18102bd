#include "tests/load/picture_fault.h"

#include <turbojpeg.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

#include <vector>

namespace heliograph::load {

std::string jpegFault(std::span<const uint8_t> bytes, uint32_t width, uint32_t height) {
    thread_local const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
    thread_local std::vector<uint8_t> pixels;
    int w = 0, h = 0, subsampling = 0, space = 0;
    if (tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &w, &h, &subsampling, &space) != 0) return "no JPEG";
    if (w != static_cast<int>(width) || h != static_cast<int>(height)) return "a JPEG of another size than its header says";
    pixels.resize(static_cast<size_t>(w) * h * 3);
    // A cut or damaged stream is a warning to the decoder, which goes on; to a viewer it is a broken picture.
    if (tjDecompress2(decoder.get(), bytes.data(), bytes.size(), pixels.data(), w, 0, h, TJPF_RGB, TJFLAG_STOPONWARNING) != 0)
        return std::string("a JPEG that does not decode: ") + tjGetErrorStr2(decoder.get());
    return {};
}

struct Vp9Decoder::State {
    vpx_codec_ctx_t codec{};
    State() { vpx_codec_dec_init(&codec, vpx_codec_vp9_dx(), nullptr, 0); }
    ~State() { vpx_codec_destroy(&codec); }
    State(const State&) = delete;
};

Vp9Decoder::Vp9Decoder() = default;
Vp9Decoder::~Vp9Decoder() = default;
void Vp9Decoder::reset() { state_.reset(); }

std::string Vp9Decoder::fault(std::span<const uint8_t> bytes, uint32_t width, uint32_t height, bool key) {
    if (!state_) state_ = std::make_unique<State>();
    vpx_codec_stream_info_t info{};
    info.sz = sizeof info;
    const auto size = static_cast<unsigned int>(bytes.size());
    if (vpx_codec_peek_stream_info(vpx_codec_vp9_dx(), bytes.data(), size, &info) != VPX_CODEC_OK) return "no VP9";
    if ((info.is_kf != 0) != key) return "a picture of a video that is a key picture against its header, or none";
    if (vpx_codec_decode(&state_->codec, bytes.data(), size, nullptr, 0) != VPX_CODEC_OK)
        return std::string("a picture of a video that does not decode: ") + vpx_codec_error(&state_->codec);
    vpx_codec_iter_t at = nullptr;
    const vpx_image_t* image = vpx_codec_get_frame(&state_->codec, &at);
    if (!image) return "a picture of a video that shows nothing";
    if (image->d_w != width || image->d_h != height) return "a picture of a video of another size than its header says";
    return {};
}

}  // namespace heliograph::load

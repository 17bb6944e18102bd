// What videos cost beside JPEG: video-bench [SCENE [PATH [PICTURES [WIDTHxHEIGHT]]]]
// Pictures of a path, 20 a second, one sample a pixel, are coded on one thread at several qualities. A row for each: processor
// ms, KB and bits a pixel of a picture, the first KB, PSNR of RGB in dB. H.264 where the build has it. For docs/measurements/feel.md.

#include "server/base/clock.h"
#include "server/device/embree/embree_device.h"
#include "server/encode/jpeg_encoder.h"
#include "server/encode/tone_map.h"
#include "server/encode/vp9_encoder.h"
#include "server/images/picture_reader.h"
#include "server/render/frame_renderer.h"
#include "server/scene/load/scene_source.h"
#include "tests/support/direct_renderer.h"
#include "tests/support/vp9_decoder.h"
#ifdef HELIOGRAPH_OPENH264
#include "server/encode/h264_encoder.h"
#include "tests/support/h264_decoder.h"
#endif

#include <algorithm>
#include <cstdio>
#include <functional>
#include <iostream>

namespace heliograph {
namespace {

constexpr double PICTURES_A_SECOND = 20.0;
constexpr uint32_t QUALITIES[] = {92, 80, 70, 60, 50, 40, 25, 10};

using Bytes = std::vector<uint8_t>;
using Decode = std::function<Bytes(const Bytes& coded, uvec2 size)>;  // to RGBA

std::vector<DisplayImage> pictures(const std::string& name, const std::string& pathName, uint32_t count, uvec2 size) {
    const std::unique_ptr<Device> device = makeEmbreeDevice();
    const std::shared_ptr<const Scene> scene = openScene(name);
    const auto path =
        std::find_if(scene->paths.begin(), scene->paths.end(), [&](const CameraPath& p) { return p.name == pathName; });
    if (path == scene->paths.end()) throw std::runtime_error("no such path: " + pathName);
    const Settings settings;
    device->load(scene, settings, {});
    test::DirectRenderer renderer(*device);
    const ToneMap map(scene->exposure, shownCurve(ToneCurve::automatic, scene->fromFile));
    std::vector<DisplayImage> images(count);
    for (uint32_t i = 0; i < count; i++) {
        const Camera camera = cameraOnPath(*path, i / PICTURES_A_SECOND / path->seconds, settings.fieldOfView);
        Film film;
        renderFrame(renderer, frameRequest(*scene, camera, settings, size, i + 1), 1, film);
        std::vector<vec4> pixels;
        film.develop(pixels);
        map.apply(pixels, size, images[i]);
    }
    return images;
}

/// A plane of colour at a pixel of the picture: between its four nearest values, weighed by 3 and 1.
double colourAt(const Bytes& plane, uint32_t width, uint32_t height, uint32_t x, uint32_t y) {
    const auto other = [](uint32_t at, uint32_t end) {
        const uint32_t half = at / 2;
        return at % 2 == 1 ? std::min(half + 1, end - 1) : half - (half > 0 ? 1 : 0);
    };
    const size_t row = size_t(y / 2) * width, nextRow = size_t(other(y, height)) * width;
    const uint32_t column = x / 2, next = other(x, width);
    return (9.0 * plane[row + column] + 3.0 * plane[row + next] + 3.0 * plane[nextRow + column] + plane[nextRow + next]) / 16.0;
}

Bytes rgbaOf(const YuvImage& yuv) {
    Bytes rgba;
    rgba.reserve(size_t(yuv.width) * yuv.height * 4);
    const auto code = [](double value) { return static_cast<uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)); };
    for (uint32_t y = 0; y < yuv.height; y++) {
        for (uint32_t x = 0; x < yuv.width; x++) {
            const double luma = 255.0 / 219.0 * (yuv.y[size_t(y) * yuv.width + x] - 16.0);
            const double u = 255.0 / 224.0 * (colourAt(yuv.u, yuv.colourWidth(), yuv.colourHeight(), x, y) - 128.0);
            const double v = 255.0 / 224.0 * (colourAt(yuv.v, yuv.colourWidth(), yuv.colourHeight(), x, y) - 128.0);
            rgba.insert(rgba.end(),
                        {code(luma + 1.5748 * v), code(luma - 0.1873 * u - 0.4681 * v), code(luma + 1.8556 * u), 255});
        }
    }
    return rgba;
}

double squares(const Bytes& a, const Bytes& b) {
    if (a.size() != b.size()) throw std::runtime_error("a picture that does not come back");
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); i++) sum += (a[i] - b[i]) * (a[i] - b[i]);  // alpha is equal
    return sum;
}

void row(const std::string& name, const std::vector<DisplayImage>& images, Encoder& encoder, uint32_t quality,
         const Decode& decode) {
    double seconds = 0.0, bytes = 0.0, error = 0.0, first = 0.0;
    Bytes coded;
    for (const DisplayImage& image : images) {
        const double before = threadCpuSeconds();
        const double others = encoder.encode(image, quality, coded);
        seconds += threadCpuSeconds() - before + others;
        bytes += static_cast<double>(coded.size());
        if (&image == images.data()) first = static_cast<double>(coded.size());
        error += squares(image.rgba, decode(coded, uvec2(image.width, image.height)));
    }
    const auto count = static_cast<double>(images.size());
    const double pixels = double(images[0].width) * images[0].height;
    const double psnr = 10.0 * std::log10(255.0 * 255.0 * 3.0 * pixels * count / error);
    std::printf("| %s | %.1f | %.1f | %.2f | %.1f | %.1f |\n", name.c_str(), 1e3 * seconds / count, bytes / count / 1024.0,
                8.0 * bytes / count / pixels, first / 1024.0, psnr);
    std::fflush(stdout);
}

void table(const std::vector<DisplayImage>& images) {
    std::printf(
        "| | processor ms | KB a picture | bit a pixel | first KB | PSNR dB |\n| --- | ---: | ---: | ---: | ---: | ---: |\n");
    const auto named = [](const char* codec, uint32_t quality, uint32_t quantizer) {
        return std::string(codec) + ", as JPEG " + std::to_string(quality) + " (quantizer " + std::to_string(quantizer) + ")";
    };
    for (const uint32_t quality : QUALITIES) {
        row("JPEG " + std::to_string(quality), images, *makeJpegEncoder(), quality, [](const Bytes& coded, uvec2 size) {
            Bytes rgba(size_t(size.x) * size.y * 4);
            readJpeg(coded, rgba);
            return rgba;
        });
    }
    for (const uint32_t quality : QUALITIES) {
        test::Vp9Decoder decoder;
        row(named("VP9", quality, vp9Quantizer(quality)), images, *makeVp9Encoder(), quality,
            [&](const Bytes& coded, uvec2) { return rgbaOf(decoder.decode(coded)); });
    }
#ifdef HELIOGRAPH_OPENH264
    for (const uint32_t quality : QUALITIES) {
        test::H264Decoder decoder;
        row(named("H.264", quality, h264Quantizer(quality)), images, *makeH264Encoder(), quality,
            [&](const Bytes& coded, uvec2 size) { return rgbaOf(decoder.decode(coded, size.x, size.y)); });
    }
#endif
}

}  // namespace
}  // namespace heliograph

int main(int argc, char** argv) {
    try {
        const auto word = [&](int i, const char* preset) { return std::string(argc > i ? argv[i] : preset); };
        heliograph::uvec2 size(1280, 720);
        std::sscanf(word(4, "").c_str(), "%ux%u", &size.x, &size.y);
        const auto count = static_cast<uint32_t>(std::stoul(word(3, "30")));
        heliograph::table(heliograph::pictures(word(1, "courtyard"), word(2, "Walk"), std::max(count, 1u), size));
    } catch (const std::exception& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}

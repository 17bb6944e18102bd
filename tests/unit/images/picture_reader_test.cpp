// PNG and JPEG against OpenImageIO, which reads them through libpng and libjpeg by its own rules: the values must be the same
// bit for bit.

#include "server/images/picture_reader.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace heliograph::TEST_FILE {
namespace {

using Bytes = std::vector<uint8_t>;

/// RGBA as OpenImageIO reads it; empty if it cannot.
Bytes expected(Bytes file, const char* format) {
    OIIO::Filesystem::IOMemReader memory(file.data(), file.size());
    const auto input = OIIO::ImageInput::create(format);
    OIIO::ImageSpec spec, config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    if (!input->set_ioproxy(&memory) || !input->open(std::string("memory.") + format, spec, config)) return {};
    const int channels = spec.nchannels;
    Bytes values(static_cast<size_t>(spec.width * spec.height * channels));
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, values.data())) return {};
    Bytes rgba;
    for (size_t i = 0; i < values.size(); i += static_cast<size_t>(channels)) {
        const uint8_t* v = &values[i];
        const bool grey = channels < 3;
        rgba.insert(rgba.end(), {v[0], v[grey ? 0 : 1], v[grey ? 0 : 2], channels % 2 ? uint8_t(255) : v[channels - 1]});
    }
    return rgba;
}

template <typename Size, typename Read>
Bytes readBy(const Bytes& file, Size size, Read read) {
    const PictureSize s = size(file);
    Bytes rgba(size_t(4) * s.width * s.height);
    read(file, rgba);
    return rgba;
}
Bytes png(const Bytes& file) { return readBy(file, readPngSize, readPng); }
Bytes jpeg(const Bytes& file) { return readBy(file, readJpegSize, readJpeg); }

Bytes noise(size_t count) {
    std::mt19937 random(11);
    Bytes bytes(count);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(random());
    return bytes;
}

struct PngKind {
    int color, depth;
    bool interlaced, transparent;
};

/// A PNG of 300 x 257 pixels, the rows random but for 16 bits, which hold every value.
Bytes pngOf(const PngKind& kind, int width = 300, int height = 257) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    Bytes file;
    png_set_write_fn(
        png, &file,
        [](png_structp p, png_bytep data, size_t size) {
            auto* to = static_cast<Bytes*>(png_get_io_ptr(p));
            to->insert(to->end(), data, data + size);
        },
        [](png_structp) {});
    png_set_IHDR(png, info, static_cast<uint32_t>(width), static_cast<uint32_t>(height), kind.depth, kind.color,
                 kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, 0, 0);
    png_set_gAMA(png, info, 0.7);  // must change nothing
    const Bytes colors = noise(3 * 256);
    if (kind.color == PNG_COLOR_TYPE_PALETTE)
        png_set_PLTE(png, info, reinterpret_cast<png_const_colorp>(colors.data()), 1 << kind.depth);
    const int most = (1 << kind.depth) - 1;
    const png_color_16 clear{0, uint16_t(3 & most), uint16_t(3 & most), uint16_t(3 & most), uint16_t(2 & most)};
    if (kind.transparent) png_set_tRNS(png, info, colors.data(), std::min(most, 100), &clear);
    png_write_info(png, info);
    const size_t rowBytes = png_get_rowbytes(png, info);
    Bytes bytes = noise(rowBytes * static_cast<size_t>(height));
    if (kind.depth == 16) {
        for (size_t i = 0; i + 1 < bytes.size(); i += 2) {
            bytes[i] = static_cast<uint8_t>(i / 2 >> 8);
            bytes[i + 1] = static_cast<uint8_t>(i / 2);
        }
    }
    std::vector<png_bytep> rows;
    for (int y = 0; y < height; y++) rows.push_back(&bytes[rowBytes * static_cast<size_t>(y)]);
    png_write_image(png, rows.data());
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    return file;
}

const std::vector<PngKind>& pngKinds() {
    static const std::vector<PngKind> kinds = [] {
        std::vector<PngKind> all;
        const auto add = [&](int color, std::vector<int> depths, bool mayBeTransparent) {
            for (const int depth : depths) {
                for (const bool interlaced : {false, true}) {
                    all.push_back({color, depth, interlaced, false});
                    if (mayBeTransparent) all.push_back({color, depth, interlaced, true});
                }
            }
        };
        add(PNG_COLOR_TYPE_GRAY, {1, 2, 4, 8, 16}, true);
        add(PNG_COLOR_TYPE_PALETTE, {1, 2, 4, 8}, true);
        add(PNG_COLOR_TYPE_RGB, {8, 16}, true);
        add(PNG_COLOR_TYPE_GRAY_ALPHA, {8, 16}, false);
        add(PNG_COLOR_TYPE_RGB_ALPHA, {8, 16}, false);
        return all;
    }();
    return kinds;
}

TEST(PngReader, GivesTheBytesThatOpenImageIoGivesForEveryKind) {
    for (const PngKind& kind : pngKinds()) {
        SCOPED_TRACE(::testing::Message() << "colour " << kind.color << " depth " << kind.depth << " interlaced "
                                          << kind.interlaced << " tRNS " << kind.transparent);
        const Bytes file = pngOf(kind);
        const Bytes want = expected(file, "png");
        ASSERT_EQ(want.size(), size_t(4) * 300 * 257);
        EXPECT_TRUE(png(file) == want);
    }
}

TEST(PngReader, RefusesWhatEndsTooEarlyOrIsDamaged) {
    const Bytes file = pngOf({PNG_COLOR_TYPE_RGB, 8, false, false}, 40, 30);
    for (size_t length = 8; length + 20 < file.size(); length += 7)
        EXPECT_THROW(png(Bytes(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length))), std::runtime_error)
            << length;
    Bytes damaged = file;
    damaged[file.size() / 2] ^= 255;
    EXPECT_THROW(png(damaged), std::runtime_error);
    EXPECT_TRUE(expected(damaged, "png").empty());
}

TEST(PngReader, NeverWritesPastTheSizeThatWasChecked) {
    const Bytes file = pngOf({PNG_COLOR_TYPE_RGB, 8, true, false}, 40, 30);
    Bytes small(40 * 29 * 4);
    EXPECT_THROW(readPng(file, small), std::runtime_error);
}

/// Smooth colours with some noise; `channels` a pixel.
Bytes jpegPixels(int width, int height, int channels) {
    Bytes pixels = noise(static_cast<size_t>(width * height * channels));
    for (size_t i = 0; i < pixels.size(); i++) {
        const int pixel = static_cast<int>(i) / channels, c = static_cast<int>(i) % channels;
        const int slope = c % 2 ? pixel / width * 255 / height : pixel % width * 255 / width;
        pixels[i] = static_cast<uint8_t>((slope * 7 + pixels[i]) / 8);
    }
    return pixels;
}

Bytes jpegOf(int format, int sampling, int flags = 0, int width = 203, int height = 117) {
    const tjhandle encoder = tjInitCompress();
    const Bytes pixels = jpegPixels(width, height, tjPixelSize[format]);
    unsigned char* to = nullptr;
    unsigned long size = 0;
    EXPECT_EQ(tjCompress2(encoder, pixels.data(), width, 0, height, format, &to, &size, sampling, 90, flags), 0);
    Bytes file(to, to + size);
    tjFree(to);
    tjDestroy(encoder);
    return file;
}

TEST(JpegReader, GivesTheBytesThatOpenImageIoGives) {
    for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
        for (const int sampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420, TJSAMP_440, TJSAMP_411, TJSAMP_GRAY}) {
            const Bytes file = jpegOf(TJPF_RGB, sampling, flags);
            EXPECT_TRUE(jpeg(file) == expected(file, "jpeg")) << sampling << " " << flags;
        }
    }
}

TEST(JpegReader, InksBecomeLightAsOpenImageIoMakesIt) {
    const Bytes file = jpegOf(TJPF_CMYK, TJSAMP_444, 0, 512, 512);
    const Bytes got = jpeg(file);
    EXPECT_TRUE(got == expected(file, "jpeg"));
    EXPECT_EQ(got[3], 255);
}

TEST(JpegReader, TakesASamplingWithoutAName) {
    Bytes file = jpegOf(TJPF_RGB, TJSAMP_444);
    // The first component of the frame header: 3 x 1 samples where the others have one.
    const uint8_t marker[] = {0xff, 0xc0};
    *(std::search(file.begin(), file.end(), marker, marker + 2) + 11) = 0x31;
    const Bytes want = expected(file, "jpeg");
    ASSERT_FALSE(want.empty());
    EXPECT_TRUE(jpeg(file) == want);
}

TEST(JpegReader, ReadsOfATruncatedFileWhatOpenImageIoReads) {
    const Bytes file = jpegOf(TJPF_RGB, TJSAMP_420);
    size_t read = 0, refused = 0;
    for (size_t length = 4; length < file.size(); length += 97) {
        const Bytes part(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length));
        const Bytes want = expected(part, "jpeg");
        if (want.empty()) {
            EXPECT_THROW(jpeg(part), std::runtime_error) << length;
            refused++;
        } else {
            EXPECT_TRUE(jpeg(part) == want) << length;
            read++;
        }
    }
    EXPECT_GT(read, 10u);
    EXPECT_GT(refused, 3u);
}

}  // namespace
}  // namespace heliograph::TEST_FILE

#include "server/images/radiance_header.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

namespace heliograph {

namespace {

constexpr size_t LONGEST_HEADER = 65536;

/// "-Y 18 +X 32": how the pixels lie. False for another line.
bool readResolution(const std::string& line, RadianceHeader& header) {
    char sign[2], axis[2];
    int length = 0;
    uint32_t size[2];
    if (std::sscanf(line.c_str(), "%c%c %9u %c%c %9u%n", &sign[0], &axis[0], &size[0], &sign[1], &axis[1], &size[1], &length) !=
            6 ||
        size_t(length) != line.size())
        return false;
    for (int i = 0; i < 2; i++) {
        if ((sign[i] != '+' && sign[i] != '-') || (axis[i] != 'X' && axis[i] != 'Y')) return false;
        if (axis[i] == 'Y') header.upwards = sign[i] == '+';
        else header.leftwards = sign[i] == '-';
    }
    if (axis[0] == axis[1]) return false;
    header.columns = axis[0] == 'X';
    header.lines = size[0];
    header.perLine = size[1];
    return true;
}

void readVariable(std::string_view line, RadianceHeader& header) {
    constexpr std::string_view EXPOSURE = "EXPOSURE=", XYZ = "FORMAT=32-bit_rle_xyze";
    if (line.substr(0, XYZ.size()) == XYZ) header.xyz = true;
    if (line.substr(0, EXPOSURE.size()) != EXPOSURE) return;
    const std::string text(line.substr(EXPOSURE.size(), 40));
    char* end = nullptr;
    const float value = std::strtof(text.c_str(), &end);
    if (end == text.c_str() || !(value > 0.0f) || !std::isfinite(value))
        throw std::runtime_error("EXPOSURE=" + text + "; a number above 0 is allowed");
    header.exposure *= value;
}

}  // namespace

RadianceHeader readRadianceHeader(std::span<const uint8_t> file) {
    const std::string_view text(reinterpret_cast<const char*>(file.data()), std::min(file.size(), LONGEST_HEADER));
    RadianceHeader header;
    size_t at = 0;
    bool variables = true;
    while (at < text.size()) {
        const size_t end = text.find('\n', at);
        if (end == std::string_view::npos) break;
        const std::string_view line = text.substr(at, end - at);
        at = end + 1;
        if (!variables) {
            if (!readResolution(std::string(line.substr(0, 80)), header)) break;
            header.bytes = at;
            return header;
        }
        if (line.empty()) variables = false;  // a blank line stands before the sizes
        else readVariable(line, header);
    }
    throw std::runtime_error("no sizes such as '-Y 18 +X 32' after its header");
}

std::vector<uint8_t> plainRadiance(const RadianceHeader& header, std::span<const uint8_t> file) {
    const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(header.lines) + " +X " +
                             std::to_string(header.perLine) + "\n";
    std::vector<uint8_t> plain(head.begin(), head.end());
    const std::span<const uint8_t> pixels = file.subspan(header.bytes);
    const bool newRuns = header.perLine >= 8 && header.perLine < 32768 && pixels.size() >= 4 && pixels[0] == 2 &&
                         pixels[1] == 2 && pixels[2] < 128;
    if (newRuns) {
        plain.insert(plain.end(), pixels.begin(), pixels.end());
        return plain;
    }
    const size_t end = plain.size() + size_t(header.lines) * header.perLine * 4;
    int shift = 0;  // runs that follow each other are the digits of one length, the lowest first
    for (size_t at = 0; at + 4 <= pixels.size() && plain.size() < end; at += 4) {
        const uint8_t* pixel = &pixels[at];
        const bool run = pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1 && plain.size() > head.size();
        if (!run) {
            plain.insert(plain.end(), pixel, pixel + 4);
            shift = 0;
            continue;
        }
        uint8_t last[4];
        std::copy_n(&plain[plain.size() - 4], 4, last);
        for (size_t n = shift < 32 ? size_t(pixel[3]) << shift : 0; n > 0 && plain.size() < end; n--)
            plain.insert(plain.end(), last, last + 4);
        shift += 8;
    }
    return plain;
}

void straighten(const RadianceHeader& header, std::vector<float>& rgb) {
    const size_t width = header.width(), height = header.height();
    const float scale = 1.0f / header.exposure;
    for (size_t i = 0; i < width * height; i++) {
        float* c = &rgb[i * 3];
        if (header.exposure != 1.0f) {
            for (int k = 0; k < 3; k++) c[k] *= scale;
        }
        if (!header.xyz) continue;
        // To Radiance's primaries with white of equal energy (Radiance, common/color.c); what lies outside of them has none.
        const float x = c[0], y = c[1], z = c[2];
        c[0] = std::max(2.5651f * x - 1.1665f * y - 0.3986f * z, 0.0f);
        c[1] = std::max(-1.0217f * x + 1.9777f * y + 0.0439f * z, 0.0f);
        c[2] = std::max(0.0753f * x - 0.2543f * y + 1.1892f * z, 0.0f);
    }
    if (!header.columns && !header.upwards && !header.leftwards) return;
    std::vector<float> turned(rgb.size());
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            const size_t row = header.upwards ? height - 1 - y : y, column = header.leftwards ? width - 1 - x : x;
            const size_t from = header.columns ? column * height + row : row * width + column;
            std::copy_n(&rgb[from * 3], 3, &turned[(y * width + x) * 3]);
        }
    }
    rgb = std::move(turned);
}

}  // namespace heliograph

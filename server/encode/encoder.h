#pragma once
// Pixels to bytes that a browser understands.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace heliograph {

/// Display-ready picture: RGBA8, sRGB coded, row-major, top row first.
struct DisplayImage {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> rgba;
};

class Encoder {
public:
    virtual ~Encoder() = default;
    virtual std::string mimeType() const = 0;
    /// Encodes into `bytes` (replaced). `quality` in [1, 100] where the format has one. Returns the processor time, in seconds,
    /// that other threads than the caller's spent on it. Throws std::runtime_error.
    virtual double encode(const DisplayImage& image, uint32_t quality, std::vector<uint8_t>& bytes) = 0;
    /// Lets go of what it keeps from one picture to the next.
    virtual void rest() {}
};

}  // namespace heliograph

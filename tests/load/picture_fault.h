#pragma once
// Whether the bytes of a picture are one: decoded as a browser would.

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace heliograph::load {

/// Whether these bytes are a whole JPEG of this size. What is wrong, or an empty text.
std::string jpegFault(std::span<const uint8_t> bytes, uint32_t width, uint32_t height);

/// Decodes one video, picture by picture.
class Vp9Decoder {
public:
    Vp9Decoder();
    ~Vp9Decoder();
    /// Another video begins.
    void reset();
    /// Whether these bytes are the next picture of the video, of this size. `key`: its header says that it needs none before
    /// it. What is wrong, or an empty text.
    std::string fault(std::span<const uint8_t> bytes, uint32_t width, uint32_t height, bool key);

private:
    struct State;
    std::unique_ptr<State> state_;  // from the first picture on
};

}  // namespace heliograph::load

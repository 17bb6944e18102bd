#pragma once
// Which parts of a scene a node asks for next, and whether what comes is right. Pure: time is an argument, in seconds.

#include "server/pool/scene_parts.h"

#include <vector>

namespace heliograph {

class PartsFetch {
public:
    /// Parts that are asked for at once: 2 MiB on the way at most.
    static constexpr size_t MOST_ASKED = 8;
    /// A part is asked for again after this time (seconds) ...
    static constexpr double PATIENCE = 2.0;
    /// ... and so often in all, before the scene is given up.
    static constexpr uint32_t MOST_TRIES = 5;

    /// Throws std::bad_alloc where the scene does not fit into memory.
    explicit PartsFetch(PartList list);

    /// Numbers of parts to ask for now.
    std::vector<uint32_t> ask(double now);
    /// A part has come. False where its bytes are not those of the list; the right ones may still come.
    bool take(uint32_t index, std::span<const uint8_t> bytes);
    bool done() const { return lacking_ == 0; }
    /// A part was asked for in vain so often that there is no hope.
    bool hopeless(double now) const;
    float share() const;
    /// The scene's bytes, once done.
    std::span<const uint8_t> bytes() const { return bytes_; }

private:
    struct Part {
        bool here = false;
        uint32_t tries = 0;
        double askedAt = 0.0;
    };
    const PartList list_;
    std::vector<Part> parts_;
    std::vector<uint8_t> bytes_;
    size_t lacking_ = 0;
    size_t first_ = 0;  // parts before it are here
};

}  // namespace heliograph

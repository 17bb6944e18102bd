#pragma once
// Where `render` puts its pictures: a file, a file for each frame, or standard output.

#include "server/base/output_file.h"
#include "server/request/view_request.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace heliograph {

/// A file name with one %d or %04d for the frame's number.
struct FramePattern {
    std::string before, after;
    uint32_t digits = 0;  // at least so many, filled up with zeros
    std::string name(uint32_t frame) const;
    bool operator==(const FramePattern&) const = default;
};
/// Nothing when the text has no such place, or more than one.
std::optional<FramePattern> framePattern(const std::string& text);

class PictureTarget {
public:
    /// `out` and `format` as typed after --out and --format; `frames`: one file for each frame, so that `out` has to be a
    /// pattern. Throws InputError before any work when a file of that name could not be written.
    PictureTarget(const std::string& out, const std::string& format, bool frames);

    PictureFormat format() const { return format_; }
    /// Pictures go to standard output, one after another, so that words have to go elsewhere.
    bool toStdout() const { return out_ == "-"; }
    std::string name(uint32_t frame) const;
    /// Whether this frame's file is there. Files appear whole.
    bool isThere(uint32_t frame) const;
    /// Throws std::runtime_error.
    void write(std::span<const uint8_t> bytes, uint32_t frame) const;

private:
    std::string out_;
    std::optional<FramePattern> pattern_;
    PictureFormat format_ = PictureFormat::png;
};

}  // namespace heliograph

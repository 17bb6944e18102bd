#pragma once
// What the header of a Radiance picture says of the pixels behind it (Ward, "Real Pixels", Graphics Gems II, 1991; Radiance's
// file formats): how they lie, by what they were multiplied, and in which colours they are.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace heliograph {

struct RadianceHeader {
    uint32_t lines = 0;      // stored one after another
    uint32_t perLine = 0;    // pixels of each
    bool columns = false;    // the lines are columns
    bool upwards = false;    // the picture's rows are stored from the bottom ("+Y")
    bool leftwards = false;  // its columns from the right ("-X")
    float exposure = 1.0f;   // product of all EXPOSURE lines: pixels were multiplied by it
    bool xyz = false;        // CIE XYZ instead of RGB
    size_t bytes = 0;        // of the header: pixels stand behind it

    uint32_t width() const { return columns ? lines : perLine; }
    uint32_t height() const { return columns ? perLine : lines; }
};

/// Reads the lines before the pixels, 64 KiB at the most. Throws std::runtime_error where there is no line such as "-Y 18 +X 32",
/// and for an exposure that is no number above 0.
RadianceHeader readRadianceHeader(std::span<const uint8_t> file);

/// The same pixels as a file that OpenImageIO reads: it knows RGB alone, and no runs of the old kind (a pixel 1 1 1 n).
std::vector<uint8_t> plainRadiance(const RadianceHeader& header, std::span<const uint8_t> file);

/// Pixels of three floats, in the order of the file, become radiance from the top left: turned, divided by the exposure, in RGB.
void straighten(const RadianceHeader& header, std::vector<float>& rgb);

}  // namespace heliograph

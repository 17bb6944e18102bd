#pragma once
// One mesh as glTF in each way that its geometry may be stored: plain, by Draco, by meshoptimizer. What decodes must be what was
// encoded, so both use the libraries' own encoders.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace heliograph::testing_files {

/// A wavy square of n x n quads in the xz plane, 0 to 1: y = sin(7 x) cos(5 z) / 8, uv = (x, z), exact normals.
struct WavyGrid {
    explicit WavyGrid(uint32_t n);

    std::vector<float> positions, normals, uvs;
    std::vector<uint32_t> indices;
    size_t vertices() const { return uvs.size() / 2; }
};

/// A view of a buffer and what else stands in its JSON, with a leading comma.
struct ViewPart {
    std::string bytes;
    std::string extra;
};

std::string plainGlb(const WavyGrid& grid);

/// `sequential`: else edgebreaker. Positions of 14 bits, normals of 10, uv of 12.
std::string dracoBytes(const WavyGrid& grid, bool sequential);
/// A GLB around bytes as dracoBytes makes them; `count`: what its accessors say of points.
std::string dracoGlb(const WavyGrid& grid, std::string_view draco, size_t count);
std::string dracoGlb(const WavyGrid& grid);

/// How the vertices of a meshopt file are stored: floats as they are, or as gltfpack does it: positions through the exponential
/// filter, normals through the octahedral one as bytes, uv as normalised 16-bit integers (KHR_mesh_quantization).
enum class MeshoptKind { exact, filtered };
/// `triangles`: the codec of triangle lists, else of index sequences. `extension`: replaced in the JSON of the first view's
/// extension, as pairs of FROM and TO. The plain buffer has no data.
std::string meshoptGlb(const WavyGrid& grid, MeshoptKind kind, bool triangles,
                       const std::vector<std::pair<std::string, std::string>>& changes = {});

}  // namespace heliograph::testing_files

#pragma once
// What stands in an OBJ file, faces as triangles. Private to server/scene.

#include "server/base/progress.h"
#include "server/scene/load/obj_text.h"
#include "server/scene/load/polygon.h"

#include <array>
#include <map>
#include <vector>

namespace heliograph {

/// Indices of a corner, from 0; -1: none.
struct ObjCorner {
    int position = -1;
    int uv = -1;
    int normal = -1;
};

struct ObjTriangle {
    std::array<ObjCorner, 3> corners;
    int material = -1;   // of ObjFile::materials; -1: none
    uint32_t group = 0;  // smoothing group, 0 = flat
};

struct ObjFile {
    std::vector<glm::dvec3> positions;  // not finite where the file has no number
    std::vector<vec3> colors;           // one a position, or empty: the file has none
    std::vector<vec3> normals;
    std::vector<vec2> uvs;  // v upwards
    std::vector<ObjTriangle> triangles;
    std::vector<std::string> materials;  // names that usemtl asks for
    std::vector<std::string> libraries;  // what stands after mtllib, line by line
    bool smoothing = false;              // has "s" lines

    /// What is wrong or not read: how many, and the first line of it.
    struct Count {
        uint64_t lines = 0;
        uint64_t first = 0;
    };
    Count badFaces;                      // an index out of range, or fewer than 3 corners
    Count badNumbers;                    // vertices with too few numbers
    Count oddNumbers;                    // vertices with something behind a number, as in 0.0*/
    std::map<std::string, Count> kinds;  // of lines that are not drawn, by their first word
    uint64_t polygonsGivenUp = 0;        // PolygonCutter::givenUp
};

/// Throws InputError for what is no text, and for more indices than fit.
ObjFile parseObj(std::span<const uint8_t> bytes, const std::string& file, const Progress& progress = {});

}  // namespace heliograph

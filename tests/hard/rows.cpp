// The forty rows, in the order of the catalogue's numbers.

#include "tests/hard/cases.h"

namespace heliograph::hard {

const std::vector<Case>& catalogue() {
    static const std::vector<Case> rows = {
        {1, "far_origin", "a body 1e6 from the origin", farOrigin, nullptr},
        {2, "tiny_scene", "scenes scaled by 2^-20 and 2^-40", tinyScene, nullptr},
        {3, "scale_sweep", "scale 2^-40 to 2^40", scaleSweep, nullptr},
        {4, "far_spheres", "balls 1e2 to 1e4 radii away", farSpheres, nullptr},
        {5, "huge_sphere", "a ball of radius 1e6 as ground", hugeSphere, nullptr},
        {6, "tangent_spheres", "rays that touch a ball", tangentSpheres, nullptr},
        {7, "inside_spheres", "rays from inside and on a ball", insideSpheres, nullptr},
        {8, "watertight_edges", "a closed body of thin triangles has no holes", watertightEdges, nullptr},
        {9, "vertex_hits", "rays aimed exactly at vertices", vertexHits, nullptr},
        {10, "double_hits", "a closed body is left an odd number of times", doubleHits, nullptr},
        {11, "slivers", "slivers, triangles without area, duplicates", slivers, nullptr},
        {12, "grazing", "a plane of 1e4 under 89.9 to 89.9999 degrees", grazing, nullptr},
        {13, "huge_triangle", "a triangle of 1e7 met at the unit scale", hugeTriangle, nullptr},
        {14, "coplanar", "two surfaces in one place", coplanar, nullptr},
        {15, "contact", "a cube over a plane, gaps of 2^0 to 2^-17", contact, nullptr},
        {16, "axis_aligned", "rays along the axes through a grid of cubes", axisAligned, nullptr},
        {17, "extremes", "sizes, directions and ends at the limits of float", extremes, nullptr},
        {18, "critical_angle", "total reflection at its angle", criticalAngle, nullptr},
        {19, "index_near_one", "indices of refraction 1, nearly 1, 0, 1e6", indexNearOne, nullptr},
        {20, "slab_energy", "a pane of glass keeps all light", slabEnergy, nullptr},
        {21, "nested_glass", "water in glass", nestedGlass, nullptr},
        {22, "absorption", "Beer-Lambert through scaled bodies", absorption, nullptr},
        {23, "parallel_mirrors", "two mirrors face each other", parallelMirrors, nullptr},
        {24, "terminator", "facets of a smooth ball under flat light", terminator, nullptr},
        {25, "bent_normals", "a normal map that looks below the horizon", bentNormals, nullptr},
        {26, "bad_attributes", "normals and positions that are no numbers", badAttributes, nullptr},
        {27, "transforms", "mirrored, flat, uneven and deep transforms", transformed, nullptr},
        {28, "lights_on_surfaces", "lights on, in and against surfaces", lightsOnSurfaces, nullptr},
        {29, "corners", "ambient occlusion in corners", corners, nullptr},
        {30, "texture_coordinates", "texture coordinates of any size", textureCoordinates, nullptr},
        {31, "environment_poles", "poles and seam of an environment", environmentPoles, nullptr},
        {32, "field_of_view", "fields of view from 0.01 to 179 degrees", fieldOfView, nullptr},
        {33, "camera_on_surface", "a camera on and in surfaces", cameraOnSurface, nullptr},
        {34, "accumulation", "a million samples of a constant", accumulation, nullptr},
        {35, "sampler", "the sampler far along its sequence", sampler, nullptr},
        {36, "containment", "a sample that is not a number", containment, nullptr},
        {37, "furnace", "bodies that reflect all light in even light", furnace, nullptr},
        {38, "devices_agree", "threads and devices give the same picture", devicesAgree, nullptr},
        {39, "animation", "animation against its formulas", nullptr, "scenes are shown at rest"},
        {40, "hostile_files", "mutations of a file", hostileFiles, nullptr},
    };
    return rows;
}

}  // namespace heliograph::hard

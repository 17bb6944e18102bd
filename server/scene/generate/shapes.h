#pragma once
// Bodies of which the scenes are built. All closed unless said otherwise, wound counter-clockwise seen from outside,
// with smooth normals where they are round and uv in metres.

#include "server/scene/generate/mesh_writer.h"

#include <functional>
#include <span>
#include <vector>

namespace heliograph::generate {

using Polyline = std::vector<vec2>;

/// Faces of a box, for leaving out those that nobody can see.
enum BoxFace : uint32_t {
    BOX_LEFT = 1,
    BOX_RIGHT = 2,
    BOX_BOTTOM = 4,
    BOX_TOP = 8,
    BOX_BACK = 16,
    BOX_FRONT = 32,
    BOX_ALL = 63
};

/// Axis-aligned box. uv follow the object's own coordinates, so neighbouring boxes continue one texture.
void addBox(MeshWriter& writer, vec3 low, vec3 high, uint32_t faces = BOX_ALL);
/// Box with its twelve edges cut off by `bevel` metres: stone never has a perfect edge, and the cut catches light.
void addBeveledBox(MeshWriter& writer, vec3 low, vec3 high, float bevel);

/// Solid of revolution about +Y. `profile` holds (radius, height); it runs so that the outside lies on its right:
/// upwards on the outside, downwards on the inside. Neighbouring pieces that meet at less than `creaseDegrees` are
/// shaded as one curve. A profile that starts and ends on the axis, or is closed, makes a watertight body.
struct LatheOptions {
    uint32_t segments = 24;
    float creaseDegrees = 35.0f;
    bool closed = false;          // the last point joins the first
    float startDegrees = 0.0f;    // where the texture's seam lies
    float textureSize = 1.0f;     // metres after which the image repeats; the girth becomes a multiple of it
};
void addLathe(MeshWriter& writer, const Polyline& profile, const LatheOptions& options = {});

/// Where a cross-section stands along a sweep: its x axis lies along `right`, its y axis along `up`; right x up points
/// forward. Lengths of the axes scale the section. `normalRight` is the axis used for normals (differs at mitred
/// joints).
struct SweepFrame {
    vec3 position{0.0f};
    vec3 right{1.0f, 0.0f, 0.0f};
    vec3 up{0.0f, 1.0f, 0.0f};
    vec3 normalRight{1.0f, 0.0f, 0.0f};
};
struct SweepOptions {
    bool closedSection = true;    // else an open strip, for mouldings whose back is buried
    bool closedPath = false;
    bool caps = false;            // flat ends; needs a convex section
    float creaseDegrees = 35.0f;
};
/// Moves `section` (counter-clockwise, outside on its right) along `frames`.
void addSweep(MeshWriter& writer, std::span<const SweepFrame> frames, const Polyline& section,
              const SweepOptions& options = {});
/// Frames along a smooth curve that turn as little as possible (parallel transport); `radius` scales the section. A
/// closed curve's leftover twist is spread over its length.
std::vector<SweepFrame> framesAlong(std::span<const vec3> curve, std::span<const float> radius, bool closed);
/// Regular polygon of radius 1, counter-clockwise.
Polyline circleSection(uint32_t corners);

/// Runs `profile` (outward distance, height) around the rectangle of half sizes (halfX, halfZ) with mitred corners:
/// plinths, string courses, cornices, steps. The profile's outside lies on its right.
void addRectangleSweep(MeshWriter& writer, float halfX, float halfZ, const Polyline& profile,
                       float creaseDegrees = 30.0f);

/// A vertical body: `section` (counter-clockwise in x and -z, about the axis, star-shaped) scaled by profile.x at
/// height profile.y, from bottom to top. Bundled columns with bases and capitals. Open at both ends.
void addProfiledPrism(MeshWriter& writer, const Polyline& section, const Polyline& profile,
                      float creaseDegrees = 35.0f);

/// A surface over the unit square, (columns x rows) cells, normals by differences; `uvScale` in metres. Open.
void addSurface(MeshWriter& writer, uint32_t columns, uint32_t rows, vec2 uvScale,
                const std::function<vec3(float, float)>& at);

/// Sphere about the origin as a lathe.
void addSphere(MeshWriter& writer, float radius, uint32_t segments, uint32_t rings);

}  // namespace heliograph::generate

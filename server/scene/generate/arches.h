#pragma once
// Arches, walls with arched openings, mouldings around them, and groined vaults. An arch lies in the xy plane with its
// springing line on y = 0 and its axis on x = 0.

#include "server/scene/generate/shapes.h"

namespace heliograph::generate {

/// Round when radius == halfSpan, pointed when it is larger (two arcs about centres on the springing line).
struct Arch {
    float halfSpan = 1.0f;
    float radius = 1.0f;

    struct Point {
        vec2 position;
        vec2 normal;  // unit, away from the opening
    };
    float rise() const;
    /// Height of the arch above the springing line at |x| <= halfSpan.
    float heightAt(float x) const;
    /// steps + 1 points from the left springing up to the apex.
    std::vector<Point> leftHalf(uint32_t steps) const;
    /// The arch `distance` further out, about the same centres.
    Arch offset(float distance) const { return {halfSpan + distance, radius + distance}; }
    /// The outline from left to right springing, apex once.
    Polyline outline(uint32_t stepsPerHalf) const;
};

/// A rectangle of wall [x0, x1] x [y0, y1] between the planes z = back and z = front, with one arched opening on the
/// axis `center`. Below the springing line the opening has vertical jambs down to the sill; sill == y0 leaves no
/// parapet. The outer edges of the rectangle stay open: panels are set side by side and end inside other bodies.
struct ArchedPanel {
    float x0, x1, y0, y1;
    float back, front;
    Arch arch;
    float center = 0.0f, springing = 0.0f, sill = 0.0f;
    uint32_t steps = 12;       // per half of the arch
    bool frontFace = true, backFace = true, soffit = true;
};
void addArchedPanel(MeshWriter& writer, const ArchedPanel& panel);

/// Moves `profile` (distance outwards from the arch, z) around the arch. It runs from the opening over the front to the
/// outside; what one sees lies on its left. `leg`: how far it continues straight down below the springing line. Open at
/// both ends.
void addArchMoulding(MeshWriter& writer, const Arch& arch, const Polyline& profile, uint32_t stepsPerHalf,
                     float leg = 0.0f, float creaseDegrees = 30.0f);

/// Two crossing vaults over the rectangle (2 arch.halfSpan) x (2 halfZ), seen from below. Across x the vault follows
/// `arch`, along z the same arch stretched, so that the groins lie on the diagonals.
void addGroinVault(MeshWriter& writer, const Arch& arch, float halfZ, uint32_t stepsPerHalf);
/// Ribs under the groins of such a vault: half width and depth in metres.
void addDiagonalRibs(MeshWriter& writer, const Arch& arch, float halfZ, uint32_t stepsPerHalf, float halfWidth,
                     float depth);

}  // namespace heliograph::generate

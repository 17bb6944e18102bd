#pragma once
// The things on the terrace of the scene `glass`. Metres, each standing on y = 0 about the y axis; glasses are closed
// bodies with real walls.

#include "server/scene/generate/mesh_writer.h"

namespace heliograph::generate {

void addWineGlass(MeshWriter& writer);
void addTumbler(MeshWriter& writer);
void addCarafe(MeshWriter& writer);
/// A sitting rabbit, 0.29 m to the tips of its ears, looking along +X.
void addRabbit(MeshWriter& writer);
/// Pot with lid, spout along +X and handle. Opaque: its parts run into each other.
void addTeapot(MeshWriter& writer);
/// A (2, 3) torus knot, upright, centred on the origin.
void addTorusKnot(MeshWriter& writer);

}  // namespace heliograph::generate

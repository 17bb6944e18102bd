#pragma once
// What the scenes of single effects (effects/...) have in common: a floor of 12 x 12 metres with a back wall, and the
// things that stand on it.

#include "server/scene/generate/mesh_writer.h"

namespace heliograph::generate {

/// Floor from -6 to 6 at height 0 and a wall at z = -3, in the present material.
void addStage(MeshWriter& writer);
/// A column with base and capital at (x, z), `height` metres high, in the present material.
void addStageColumn(MeshWriter& writer, float x, float z, float height);
/// A ball of 64 x 32 quads about `center`, in the present material.
void addStageBall(MeshWriter& writer, vec3 center, float radius);
/// Two viewpoints, a round and what else every scene of an effect has.
void finishStage(SceneBuilder& builder, MeshWriter& writer, vec3 sky);

}  // namespace heliograph::generate

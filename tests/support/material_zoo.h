#pragma once
// A scene with a body of every kind of material, baked and placed, under every kind of light.

#include "server/scene/build/scene_builder.h"

namespace heliograph::test {

/// About 60 bodies on a floor in x and z from 0 to 10, y up. Every effect of the table is called for, those of layers
/// where they are asked for: programs with all of them take minutes to compile on a processor.
std::shared_ptr<const Scene> materialZoo(bool withLayers = false);

/// A view of it.
NamedCamera zooCamera();

}  // namespace heliograph::test

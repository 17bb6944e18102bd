#pragma once
// The generated scenes, one source file each.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

void fillCourtyard(SceneBuilder& builder);
void fillCathedral(SceneBuilder& builder);
void fillGlass(SceneBuilder& builder);
void fillCornell(SceneBuilder& builder);
void fillSoftShadows(SceneBuilder& builder);
void fillHardShadows(SceneBuilder& builder);
void fillDepthOfField(SceneBuilder& builder);
void fillFog(SceneBuilder& builder);
void fillGlossy(SceneBuilder& builder);
void fillMotionBlur(SceneBuilder& builder);
void fillIndirectLight(SceneBuilder& builder);
void fillSmallMirror(SceneBuilder& builder);
void fillNoMirror(SceneBuilder& builder);

}  // namespace heliograph

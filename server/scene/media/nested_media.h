#pragma once
// Bodies that stand in each other, as water in a glass: numbers their media by priority and sees to it that walls that lie on
// each other overlap, so that the kernel (shaders/kernel/effects/nested_media.glsl) meets them one after the other. Private to
// server/scene.
//
// Priority: what the file says (Material.priority) decides; among equals the smaller body wins, since of two that overlap it is
// the one that was put into the other: ice in water, a bubble in ice, the wall of a glass against what it holds.

#include "server/scene/build/scene_draft.h"

namespace heliograph {

/// A number of a medium has seven bits.
constexpr uint32_t MOST_MEDIA = 127;

/// Of a body's farthest corner from the origin: how far its walls are moved outwards where another body may stand in it, five to
/// ten times the clearance from which rays start. Media of higher priority are moved up to twice as far.
constexpr double WALL_OVERLAP = 0x1p-17;

/// Numbers the media of the draft's materials and, where boxes of bodies of two media touch, moves the walls of those bodies.
/// Counts such bodies in scene.nestedBodies and keeps the boxes of all bodies in scene.bodyBounds then. Beyond MOST_MEDIA nothing
/// is numbered, with a warning: bodies are computed as against air. Meshes have to be prepared.
void nestMedia(SceneDraft& draft);

}  // namespace heliograph

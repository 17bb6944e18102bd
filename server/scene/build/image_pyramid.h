#pragma once
// Mip pyramids in the kernel's texel format. Private to server/scene.

#include "server/scene/build/scene_builder.h"

namespace heliograph {

/// One linear value as the kernel will read it: shared exponent, 9 bits a channel. Negative and NaN count as 0, what is
/// above 65408 as 65408. EXT_texture_shared_exponent (Khronos, 2008).
uint32_t packRgb9e5(vec3 color);
vec3 unpackRgb9e5(uint32_t word);

/// sRGB electro-optical transfer, 0..1 to 0..1 (IEC 61966-2-1).
double srgbToLinear(double coded);
double linearToSrgb(double linear);

/// Texels of the whole pyramid of a width x height image.
uint64_t pyramidTexels(uint32_t width, uint32_t height);

/// Appends the image and its pyramid, filtered in linear light by area (odd sizes too), to the scene's arrays.
/// `weighByAlpha`: colours of transparent texels do not bleed into their neighbours (for textures whose alpha is used).
/// Frees the pixels.
void appendPyramid(Scene& scene, ImageData& image, bool weighByAlpha);

}  // namespace heliograph

// One row per effect: EFFECT(bit, CONSTANT, name, setting, parent, positive, rule, tier, help). The including file defines
// EFFECT; the table undefines it.
// A scene calls for an effect by its rule (request/effect_rules), a viewer's settings allow it (request/effects); what is not
// in both costs no ray.
// setting: the switch that allows it, or a choice that does where it is not its first word. parent: constant of an effect of an earlier row that must be allowed too, or 0. positive: a
// setting that must be above 0. `none` where there is no such setting.
// rule: a function of request/effect_rules.cpp; `anywhere` where the viewer alone chooses.
// tier: the first of the CPU's tile programs that has it compiled in (tile_programs_isa.cpp): plain, mirrors, occlusion, sharp, spread, everything.
EFFECT(0, EFFECT_SHADOWS, shadows, shadows, 0, none, shadows, plain, "Shadows: one ray per light and hit.")
EFFECT(1, EFFECT_TRANSPARENT_SHADOWS, transparentShadows, shadows, 0, none, transparentShadows, sharp, "Shadow rays pass transparent surfaces and take their colour.")
EFFECT(2, EFFECT_REFLECTIONS, reflections, reflections, 0, none, reflections, mirrors, "Mirror reflections on smooth metals, glass and polished surfaces.")
EFFECT(3, EFFECT_REFRACTIONS, refractions, refractions, 0, none, refractions, sharp, "Refraction through transmissive surfaces.")
EFFECT(4, EFFECT_AMBIENT_OCCLUSION, ambientOcclusion, ambientOcclusion, 0, aoRadius, onLitSurfaces, occlusion, "Ambient light is darkened where near geometry hides the sky.")
EFFECT(5, EFFECT_ENVIRONMENT_IMAGE, environment, environment, 0, none, environment, plain, "A lat-long image surrounds the scene.")
EFFECT(6, EFFECT_TEXTURES, textures, none, 0, none, textures, plain, "Images on surfaces.")
EFFECT(7, EFFECT_NORMAL_MAPS, normalMaps, none, 0, none, normalMaps, mirrors, "Normal or bump images tilt the shading normal.")
EFFECT(8, EFFECT_VERTEX_COLORS, vertexColors, none, 0, none, vertexColors, sharp, "Colours stored at vertices.")
EFFECT(9, EFFECT_ALPHA_MASK, alphaMask, none, 0, none, alphaMask, sharp, "Cut-out surfaces: a texel is there or not.")
EFFECT(10, EFFECT_ALPHA_BLEND, alphaBlend, none, 0, none, alphaBlend, sharp, "Surfaces that let a part of the light straight through.")
EFFECT(11, EFFECT_ABSORPTION, absorption, refractions, 0, none, absorption, sharp, "Coloured glass darkens with the distance travelled in it (Beer-Lambert).")
EFFECT(12, EFFECT_EMISSION, emission, none, 0, none, emission, plain, "Surfaces that glow.")
EFFECT(13, EFFECT_INSTANCING, instancing, none, 0, none, instancing, sharp, "One mesh stands in several places.")
EFFECT(14, EFFECT_TANGENTS, tangents, none, 0, none, tangents, mirrors, "Tangents stored at vertices steer the normal maps.")
EFFECT(15, EFFECT_SECOND_UV, secondTextureCoordinates, none, 0, none, secondTextureCoordinates, sharp, "A texture uses the second set of coordinates.")
EFFECT(16, EFFECT_SOFT_SHADOWS, softShadows, softShadows, EFFECT_SHADOWS, none, softShadows, spread, "Lights with an extent throw shadows with soft edges: several rays per light and hit.")
EFFECT(17, EFFECT_DEPTH_OF_FIELD, depthOfField, depthOfField, 0, aperture, anywhere, spread, "What is not at the focus distance is blurred, as by a lens.")
EFFECT(18, EFFECT_FOG, fog, fog, 0, fogDensity, anywhere, spread, "The air dims what is far and shows the light that falls through it.")
EFFECT(19, EFFECT_GLOSSY_REFLECTIONS, glossyReflections, glossyReflections, EFFECT_REFLECTIONS, none, glossyReflections, spread, "Surfaces between smooth and rough reflect blurred.")
EFFECT(20, EFFECT_MOTION_BLUR, motionBlur, motionBlur, 0, shutter, anywhere, spread, "A moving camera blurs the picture along its way.")
EFFECT(21, EFFECT_INDIRECT_LIGHT, indirectLight, indirectLight, 0, none, onLitSurfaces, spread, "Surfaces light each other: bounces of light instead of the ambient light.")
EFFECT(22, EFFECT_FILTERED_ENVIRONMENT, filteredEnvironment, environment, EFFECT_ENVIRONMENT_IMAGE, none, filteredEnvironment, sharp, "Rough surfaces reflect the environment image from levels that are blurred by their lobe, and diffuse ones its irradiance.")
EFFECT(23, EFFECT_ENVIRONMENT_LIGHT, environmentLight, environmentLight, EFFECT_ENVIRONMENT_IMAGE, none, environmentLight, everything, "Bright places of the environment image, as a sun, light the scene and throw shadows: one ray a visible point.")
EFFECT(24, EFFECT_SURFACE_LIGHTS, surfaceLights, surfaceLights, 0, none, surfaceLights, everything, "Glowing surfaces light others: one ray a visible point, to a place that is chosen by power.")
EFFECT(25, EFFECT_ROUGH_GLASS, roughGlass, roughGlass, EFFECT_REFRACTIONS, none, roughGlass, everything, "Rough glass blurs what is seen through it and what it reflects.")
EFFECT(26, EFFECT_PATH, path, integrator, 0, none, path, everything, "All bounces of light: one path a sample, with rays to the lights from each surface on it.")
EFFECT(27, EFFECT_ANISOTROPIC_TEXTURES, anisotropicTextures, textureFilter, 0, none, textures, spread, "Textures that are seen at a flat angle stay sharp across: several samples along the long way.")
EFFECT(28, EFFECT_OCCLUSION_TEXTURES, occlusionTextures, occlusionTextures, 0, none, occlusionTextures, sharp, "Images say how much ambient light hollows get, where no ray finds that out.")
EFFECT(29, EFFECT_NESTED_MEDIA, nestedMedia, refractions, 0, none, nestedMedia, everything, "Bodies stand in each other, as water in a glass: light bends by what is on either side, and where they overlap one fills the place.")
EFFECT(30, EFFECT_MANY_LIGHTS, manyLights, manyLights, 0, none, manyLights, everything, "Of many lights a few are asked from each point, chosen by what they may bring there.")
EFFECT(31, EFFECT_DISPERSION, dispersion, refractions, EFFECT_REFRACTIONS, none, dispersion, everything, "Glass bends blue more than red.")
EFFECT(32, EFFECT_CLEARCOAT, clearcoat, none, 0, none, clearcoat, everything, "A clear coat of varnish reflects over what is under it.")
EFFECT(33, EFFECT_SHEEN, sheen, none, 0, none, sheen, everything, "Cloth shines at its rim.")
EFFECT(34, EFFECT_ANISOTROPY, anisotropy, none, 0, none, anisotropy, everything, "Highlights are longer one way, as on brushed metal.")
EFFECT(35, EFFECT_IRIDESCENCE, iridescence, none, 0, none, iridescence, everything, "Thin films change colour with the angle.")
EFFECT(36, EFFECT_DIFFUSE_TRANSMISSION, diffuseTransmission, none, 0, none, diffuseTransmission, everything, "Light scatters through thin things to their other side, as through leaves and paper.")
EFFECT(37, EFFECT_SUN, sun, sun, 0, sunStrength, onLitSurfaces, spread, "A sun shines from where the viewer puts it, beside the scene's own lights.")
EFFECT(38, EFFECT_GROUND, ground, ground, 0, none, anywhere, everything, "Ground that shows nothing but the shadows on it, under what would float.")
EFFECT(39, EFFECT_MANY_LAMPS, manyLamps, manyLights, EFFECT_SURFACE_LIGHTS, none, manyLamps, everything, "Of many glowing triangles that is asked which may bring most, by power and distance.")
#undef EFFECT

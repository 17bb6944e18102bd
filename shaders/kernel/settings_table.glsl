// One row per setting; C++, GLSL, JSON and the client's form all follow from this table.
// SETTING_BOOL(name, group, acts, default, label, effect, price, help)
// SETTING_INT(name, group, acts, default, low, high, unit, label, effect, price, help)
// SETTING_FLOAT(name, group, acts, default, low, high, unit, label, effect, price, help)
// SETTING_CHOICE(name, group, acts, default, "a|b|c", label, effect, price, help)        stored as the index of the choice
// DEVICE_WORDS: auto, the words of request/device_table.inc, hybrid.
// group: where it stands in the form: picture, effects, renderer or hybrid. acts: what it changes (request/settings.h):
// film, the samples; display, the picture made of them; loop, how many samples and pixels there shall be by when; command, nothing in a viewer's view.
// effect: the effect_table row it belongs to, or "". price: which direction is exact and dearer: "up", "down", "on", "off" or "".
// The K rows (SETTING_K_*) are also fields of the kernel's settings block.
// The including file defines what it needs: a K row falls back on its plain form, and that one on SETTING(name, group, acts).
#ifndef SETTING
#define SETTING(name, group, acts)
#endif
#ifndef SETTING_BOOL
#define SETTING_BOOL(name, group, acts, def, label, effect, price, help) SETTING(name, group, acts)
#endif
#ifndef SETTING_INT
#define SETTING_INT(name, group, acts, def, low, high, unit, label, effect, price, help) SETTING(name, group, acts)
#endif
#ifndef SETTING_FLOAT
#define SETTING_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help) SETTING(name, group, acts)
#endif
#ifndef SETTING_CHOICE
#define SETTING_CHOICE(name, group, acts, def, choices, label, effect, price, help) SETTING(name, group, acts)
#endif
#ifndef SETTING_K_INT
#define SETTING_K_INT(name, group, acts, def, low, high, unit, label, effect, price, help) SETTING_INT(name, group, acts, def, low, high, unit, label, effect, price, help)
#endif
#ifndef SETTING_K_FLOAT
#define SETTING_K_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help) SETTING_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help)
#endif
SETTING_CHOICE(device, renderer, film, 0, DEVICE_WORDS, "Device", "", "", "Which renderer makes the picture. auto takes the fastest one present, hybrid all of them together.")
SETTING_CHOICE(hybridBalance, hybrid, film, 0, "auto|manual", "Balance", "", "", "How hybrid divides the picture: auto gives each region to whoever finishes it first, manual cuts it where the share says.")
SETTING_INT(hybridShare, hybrid, film, 50, 0, 100, "%", "Vulkan share", "", "", "Part of the work that goes to Vulkan devices when the balance is manual; the CPU gets the rest.")
SETTING_BOOL(showPartition, hybrid, film, false, "Show partition", "", "", "Tints each cell by the device that made it and draws who worked when.")
SETTING_BOOL(enableEmbree, hybrid, film, true, "Embree takes part", "", "", "Whether the CPU works along in hybrid.")
SETTING_BOOL(enableVulkan, hybrid, film, true, "Vulkan takes part", "", "", "Whether Vulkan devices work along in hybrid.")
SETTING_FLOAT(renderScale, picture, film, 1.0f, 0.125f, 1.0f, "x", "Render scale", "", "up", "Rendered resolution as a share of the window. Lower is faster and softer.")
SETTING_BOOL(automaticScale, picture, loop, true, "Scale while moving", "", "off", "While the camera moves, fewer pixels are rendered where it takes that to reach the frame rate; at rest it is the render scale again. Off keeps the render scale always.")
SETTING_INT(frameRate, picture, loop, 20, 1, 60, "/s", "Frame rate", "", "", "Pictures a second that the automatic scale aims at while the camera moves.")
SETTING_FLOAT(timeBudget, picture, loop, 0.0f, 0.0f, 10000.0f, "ms", "Time budget", "", "", "While the camera moves, a picture may take so long to render: rays are left out first, in the order of what they bring for their time, then pixels. At rest everything is as set again. 0: no budget, the frame rate alone says.")
SETTING_INT(samples, picture, loop, 64, 1, 65536, "per pixel", "Samples at rest", "", "up", "How many samples a pixel collects while the camera rests. More samples, smoother edges.")
SETTING_FLOAT(errorTarget, picture, loop, 0.0f, 0.0f, 50.0f, "%", "Error target", "", "down", "While the camera rests, no more samples are added once the picture's estimated error is this small, or the samples at rest are there. 0: never for that reason.")
SETTING_BOOL(adaptive, picture, loop, false, "Adaptive samples", "", "off", "With an error target: parts of the picture get samples by how much error these take there, and none any more where they take little. Reaches the target sooner. Off, all pixels get as many.")
SETTING_CHOICE(integrator, effects, film, 0, "interactive|path", "Integrator", "path", "", "interactive estimates light that bounces often and is clear after few samples. path follows all bounces: right, and grainy until it has hundreds of samples.")
SETTING_K_INT(maxBounces, effects, film, 16, 1, 255, "bounces", "Max bounces", "path", "up", "How many surfaces in a row a path is followed to. What comes after is black.")
SETTING_K_INT(russianRoulette, effects, film, 0, 0, 255, "bounces", "Russian roulette", "path", "", "After so many bounces a path ends by chance, the sooner the less it carries. Fewer rays, more grain, the same mean. 0: never.")
SETTING_BOOL(shadows, effects, film, true, "Shadows", "shadows", "on", "Shadows from every light. Costs one ray per light and visible point.")
SETTING_BOOL(softShadows, effects, film, true, "Soft shadows", "softShadows", "on", "Lights that have an extent throw soft shadows; off takes them as points.")
SETTING_K_INT(shadowSamples, effects, film, 4, 1, 256, "rays", "Shadow samples", "softShadows", "up", "Rays per light with an extent, visible point and sample. More rays, less grain in half shadows.")
SETTING_BOOL(manyLights, effects, film, true, "Many lights", "manyLights", "off", "Where a scene has more than 32 lights with a place, some are asked from each visible point, chosen by what they may bring there: grain instead of time, and the same mean. Off asks all.")
SETTING_K_INT(lightRays, effects, film, 2, 1, 256, "rays", "Light rays", "manyLights", "up", "Rays per visible point and sample to lights that are chosen of many. More rays, less grain.")
SETTING_BOOL(reflections, effects, film, true, "Reflections", "reflections", "on", "Mirror reflections on metals, glass and polished floors.")
SETTING_K_INT(maxReflections, effects, film, 1, 0, 31, "bounces", "Max reflections", "reflections", "up", "How many reflections in a row are followed. The rest is estimated from the environment.")
SETTING_BOOL(glossyReflections, effects, film, false, "Glossy reflections", "glossyReflections", "on", "Surfaces of every roughness reflect the scene, blurred. Costs a ray per visible point that is rough, and takes samples to become smooth. Off, rough surfaces reflect the surroundings alone.")
SETTING_BOOL(refractions, effects, film, true, "Refractions", "refractions", "on", "Light that passes through glass is bent and tinted.")
SETTING_K_INT(maxRefractions, effects, film, 8, 0, 31, "bounces", "Max refractions", "refractions", "up", "How many refracting surfaces in a row are followed. The rest is estimated from the environment.")
SETTING_BOOL(ambientOcclusion, effects, film, false, "Ambient occlusion", "ambientOcclusion", "on", "Corners and contacts get less ambient light.")
SETTING_K_INT(aoSamples, effects, film, 9, 1, 256, "rays", "AO samples", "ambientOcclusion", "up", "Rays per visible point and sample. More rays, less grain.")
SETTING_K_FLOAT(aoRadius, effects, film, 1.0f, 0.0f, 1000.0f, "x scene", "AO radius", "ambientOcclusion", "", "How far a neighbour may be to darken, as a multiple of the radius that suits the scene. 0 turns the darkening off.")
SETTING_K_FLOAT(aoPower, effects, film, 1.0f, 0.0f, 10.0f, "", "AO power", "ambientOcclusion", "", "Contrast of the darkening: the visible share is raised to this power. 1 is physical.")
SETTING_BOOL(occlusionTextures, effects, film, true, "Occlusion images", "occlusionTextures", "", "Images that come with a material darken its hollows. Only ambient light, and only where neither ambient occlusion nor the path integrator finds out what hides it.")
SETTING_BOOL(indirectLight, effects, film, false, "Indirect light", "indirectLight", "on", "Surfaces light each other in the place of ambient light and its occlusion. Costs one ray per visible point and bounce, and the light rays where it ends.")
SETTING_K_INT(indirectBounces, effects, film, 1, 1, 16, "bounces", "Indirect bounces", "indirectLight", "up", "How many times in a row surfaces light each other before ambient light stands for the rest. Rooms take 3 or 4; each costs a ray and its light rays.")
SETTING_BOOL(surfaceLights, effects, film, true, "Glowing surfaces", "surfaceLights", "on", "Glowing surfaces light others and throw shadows. Costs one ray per visible point and sample.")
SETTING_BOOL(environmentLight, effects, film, true, "Environment light", "environmentLight", "on", "Bright places of the environment image, as a sun, throw shadows. Costs one ray per visible point and sample.")
SETTING_BOOL(roughGlass, effects, film, true, "Rough glass", "roughGlass", "on", "Frosted glass blurs what is behind it. Costs no more rays, but takes samples to become smooth.")
SETTING_BOOL(depthOfField, effects, film, false, "Depth of field", "depthOfField", "on", "Blurs what is nearer or farther than the focus distance. Costs no rays, but takes samples to become smooth.")
SETTING_K_FLOAT(aperture, effects, film, 0.05f, 0.0f, 100.0f, "m", "Aperture", "depthOfField", "", "Diameter of the lens: the wider, the more is blurred. 0 is a pinhole, everything is sharp.")
SETTING_K_FLOAT(focusDistance, effects, film, 5.0f, 0.0f, 1000000.0f, "m", "Focus distance", "depthOfField", "", "How far in front of the camera everything is sharp.")
SETTING_BOOL(motionBlur, effects, film, false, "Motion blur", "motionBlur", "on", "Blurs the picture along the way of a moving camera. Costs no rays, but takes samples to become smooth.")
SETTING_K_FLOAT(shutter, effects, film, 0.5f, 0.0f, 1.0f, "x frame", "Shutter", "motionBlur", "", "How much of the time between two frames the shutter is open. 0 freezes the motion.")
SETTING_BOOL(fog, effects, film, false, "Fog", "fog", "on", "Fills the scene with fog: far things fade, light becomes visible. Costs rays per light and path.")
SETTING_K_FLOAT(fogDensity, effects, film, 0.5f, 0.0f, 1000.0f, "x scene", "Fog density", "fog", "", "At 1 a third of the light gets through across the scene's radius. 0 is clear air.")
SETTING_K_FLOAT(fogAlbedo, effects, film, 0.9f, 0.0f, 1.0f, "", "Fog brightness", "fog", "", "Share of the light that the fog scatters; the rest it swallows. 0 is smoke, 1 is mist.")
SETTING_K_INT(fogSamples, effects, film, 1, 1, 64, "rays", "Fog samples", "fog", "up", "Rays per light and stretch of a path. More rays, less grain in shafts of light.")
SETTING_CHOICE(textureFilter, effects, film, 0, "trilinear|anisotropic", "Texture filter", "anisotropicTextures", "up", "anisotropic keeps textures sharp that are seen at a flat angle: up to 16 samples in a row instead of one. trilinear blurs them across.")
SETTING_BOOL(environment, effects, film, true, "Environment image", "environment", "on", "Show and reflect the environment image; off uses its mean colour.")
SETTING_K_FLOAT(contributionThreshold, renderer, film, 0.004f, 0.0f, 0.5f, "", "Contribution threshold", "", "down", "Rays that can change a pixel by less than this are not followed. 0 follows all.")
SETTING_CHOICE(surroundings, picture, film, 0, "automatic|studio|sky|grey|none", "Surroundings", "", "", "What stands around the scene and lights it. automatic: what the scene brings, and the studio for a file without any light. studio: soft boxes in a white room; sky: a clear day; grey: even light; none: darkness.")
SETTING_FLOAT(environmentRotation, picture, film, 0.0f, -180.0f, 180.0f, "deg", "Turn of surroundings", "", "", "Turns what stands around the scene about the vertical axis.")
SETTING_FLOAT(environmentStrength, picture, film, 1.0f, 0.0f, 100.0f, "x", "Strength of surroundings", "", "", "Multiplies the light of what stands around the scene.")
SETTING_BOOL(ground, effects, film, false, "Ground", "ground", "", "Catches the shadows of the scene under its lowest point; what is behind shows through. Even light is kept from it as far as the AO radius says.")
SETTING_BOOL(sun, effects, film, false, "Sun", "sun", "", "Adds a sun to what lights the scene.")
SETTING_FLOAT(sunAzimuth, effects, film, 35.0f, -180.0f, 180.0f, "deg", "Sun direction", "sun", "", "Where the sun stands, about the vertical axis: 0 is the side that a model from a file shows to its viewer (+Z), 90 the viewer's right.")
SETTING_FLOAT(sunElevation, effects, film, 45.0f, -90.0f, 90.0f, "deg", "Sun height", "sun", "", "Angle of the sun over the horizon.")
SETTING_FLOAT(sunSize, effects, film, 0.53f, 0.0f, 90.0f, "deg", "Sun size", "sun", "", "Angle that the sun's disc fills, 0.53 from the earth. Larger, shadows become softer; 0 makes them sharp.")
SETTING_FLOAT(sunStrength, effects, film, 3.0f, 0.0f, 1000.0f, "", "Sun strength", "sun", "", "Irradiance on a surface that faces the sun: at pi a white one comes out white.")
SETTING_CHOICE(background, picture, film, 0, "automatic|image|plain|blurred", "Background", "", "", "What is seen behind the scene: the image that lights it, one grey, or that image blurred. automatic is plain for files in the studio, else the image.")
SETTING_FLOAT(exposure, picture, display, 0.0f, -10.0f, 10.0f, "EV", "Exposure", "", "", "Brightness of the picture in stops; +1 doubles it.")
SETTING_CHOICE(autoExposure, picture, display, 0, "automatic|on|off", "Automatic exposure", "", "", "Brings the mean brightness of the picture to that of mid grey, and keeps it while the camera moves. automatic does so in a view of a file that brings lights of its own, never in commands.")
SETTING_CHOICE(toneCurve, picture, display, 0, "automatic|neutral|filmic|aces|linear", "Tone curve", "", "", "neutral keeps colours as they are below 0.8, filmic has more contrast and rolls highlights off softly, aces lets bright colours turn pale as on film, linear clips at white. automatic is neutral for files and filmic for the scenes that come along.")
SETTING_BOOL(adaptiveQuality, picture, display, true, "Adaptive quality", "", "off", "Where pictures queue up on the line, JPEG quality and size go down, and up again when it is free. Off sends every picture as set.")
SETTING_BOOL(showError, picture, display, false, "Show error", "", "", "Tints the picture by the error that each part of it is estimated to have, from two samples on.")
SETTING_CHOICE(codec, picture, display, 0, "automatic|jpeg|vp9|h264", "Codec", "", "", "How pictures are coded while they change. vp9 and h264 are videos: a quarter of the bytes and less, for more work here and there. automatic takes one where the line is too slow for jpeg and both the server and the browser know it. h264 is there only where the server was built with it.")
SETTING_CHOICE(denoiser, picture, display, 0, "off|filter|oidn", "Denoiser", "", "", "Takes what few samples cannot tell from neighbours on the same surface: less grain, for some sharpness, 10 to 90 ms a picture at 1280x720 and 113 bytes a pixel of memory. Such a picture is never called exact. Left out with depth of field and motion blur. oidn is Open Image Denoise, where the server has it.")
SETTING_BOOL(exactAtRest, picture, display, true, "Exact at rest", "", "on", "When all samples are there, the picture is sent once more without loss: the same bytes as on the server.")
SETTING_BOOL(cameraPath, picture, command, false, "Camera path", "", "", "Fly along the scene's camera path.")
SETTING_FLOAT(fieldOfView, picture, command, 60.0f, 0.01f, 179.0f, "deg", "Field of view", "", "", "Vertical opening angle of the camera.")
SETTING_CHOICE(rasterView, renderer, film, 0, "shaded|normals|depth|material|primitive", "Raster view", "", "", "What the raster preview shows: the lit surface without shadows, or normals, depth, materials and triangles for looking into meshes.")
SETTING_INT(embreeThreads, renderer, film, 0, 0, 256, "threads", "Embree threads", "", "", "Threads that trace on the CPU; 0 uses every core.")
SETTING_BOOL(tiles, renderer, film, true, "Tiles", "", "", "Render in tiles; off renders rows of the full width, 8 pixels high.")
SETTING_CHOICE(tileWidth, renderer, film, 2, "8|16|32|64|128|256", "Tile width", "", "", "Width of a CPU tile, in pixels.")
SETTING_CHOICE(tileHeight, renderer, film, 2, "8|16|32|64|128|256", "Tile height", "", "", "Height of a CPU tile, in pixels.")
SETTING_BOOL(primaryPackets, renderer, film, true, "Primary packets", "", "", "Trace camera and shadow rays in packets instead of one by one.")
SETTING_BOOL(secondaryPackets, renderer, film, true, "Secondary packets", "", "", "Trace ambient occlusion, reflection and refraction rays in packets.")
SETTING_CHOICE(bvhQuality, renderer, film, 1, "low|medium|high", "BVH quality", "", "", "Quality of the acceleration structure: higher builds slower and may trace faster.")
SETTING_BOOL(exactRounding, renderer, film, true, "Exact rounding", "", "on", "Graphics processors round quotients and roots as the processor does: the same picture bit by bit. Off is a little faster there.")
SETTING_BOOL(robust, renderer, film, false, "Robust traversal", "", "on", "Watertight traversal: no ray slips through an edge. Costs 5 to 19 percent.")
SETTING_INT(jpegQuality, picture, display, 80, 10, 100, "", "JPEG quality", "", "up", "Quality of the streamed picture while it changes.")
#undef SETTING
#undef SETTING_BOOL
#undef SETTING_INT
#undef SETTING_FLOAT
#undef SETTING_CHOICE
#undef SETTING_K_INT
#undef SETTING_K_FLOAT

// Every struct that a device sees, in one layout for C++ and GLSL (std430). Groups of 16 bytes; sizes are asserted in
// kernel_types.h. Units: metres as the scene gives them, radiance in linear Rec. 709, angles in radians.
#ifndef HELIOGRAPH_TYPES_GLSL
#define HELIOGRAPH_TYPES_GLSL

UINT_CONSTANT(NO_INDEX, 0xffffffffu)

// Words from Material.layers on.
#define LAYER_NUMBER(word, name, def) UINT_CONSTANT(LAYER_##name, uint(word))
#define LAYER_WORD(word, name) UINT_CONSTANT(LAYER_##name, uint(word))
#include "layer_table.glsl"

// Effect bits, from the table. Those from 32 on are told apart by a word of their own: HAS_LAYER instead of HAS.
#define EFFECT(bit, CONSTANT, name, setting, parent, positive, rule, tier, help) EFFECT_CONSTANT(CONSTANT, bit)
#include "effect_table.glsl"
// No effect of a picture but another one: what the denoiser looks at (guides.glsl).
EFFECT_CONSTANT(EFFECT_GUIDES, 63)

// Material.flags
UINT_CONSTANT(MATERIAL_PHONG, 1u)         // Phong/MTL model; else metallic-roughness
UINT_CONSTANT(MATERIAL_UNLIT, 2u)         // shows its base colour
UINT_CONSTANT(MATERIAL_ALPHA_MASK, 4u)    // cut-out at alphaCutoff
UINT_CONSTANT(MATERIAL_ALPHA_BLEND, 8u)   // 1 - alpha passes straight through
UINT_CONSTANT(MATERIAL_VOLUME, 16u)       // a solid body: refracts and absorbs; else thin-walled
UINT_CONSTANT(MATERIAL_BUMP, 32u)         // normalTexture holds heights, not normals
UINT_CONSTANT(MATERIAL_OPACITY_RED, 64u)  // opacityTexture's red is alpha (MTL map_d)
UINT_CONSTANT(MATERIAL_LIT_APART, 128u)   // glows and lights nothing: a light of its own stands for it

// Luminance of linear sRGB, ITU-R BT.709.
KERNEL_CONSTANT float LUMINANCE_RED = 0.2126f;
KERNEL_CONSTANT float LUMINANCE_GREEN = 0.7152f;
KERNEL_CONSTANT float LUMINANCE_BLUE = 0.0722f;

// What materials and textures of a scene may do and others do not: a device that compiles per scene leaves out what its
// scene does not hold (MET, compat.glsl). Some run both sides of every branch, so that there code costs time unmet.
UINT_CONSTANT(VARIETY_BASE_TEXTURE, 1u)
UINT_CONSTANT(VARIETY_OPACITY_TEXTURE, 2u)
UINT_CONSTANT(VARIETY_METALLIC_ROUGHNESS_TEXTURE, 4u)
UINT_CONSTANT(VARIETY_TRANSMISSION_TEXTURE, 8u)
UINT_CONSTANT(VARIETY_SPECULAR_TEXTURE, 16u)
UINT_CONSTANT(VARIETY_EMISSION_TEXTURE, 32u)
UINT_CONSTANT(VARIETY_BUMP, 64u)            // a normal texture that holds heights
UINT_CONSTANT(VARIETY_NEAREST, 128u)        // a texture without filtering
UINT_CONSTANT(VARIETY_WRAP, 256u)           // a texture that is clamped or mirrored
UINT_CONSTANT(VARIETY_SHARED_EXPONENT, 512u)  // an image of format IMAGE_RGB9E5
UINT_CONSTANT(VARIETY_PHONG, 1024u)
UINT_CONSTANT(VARIETY_MICROFACET, 2048u)
UINT_CONSTANT(VARIETY_UNLIT, 4096u)

// One vertex beside its position, 32 bytes.
struct VertexAttributes {
    vec3 normal;  // unit, object space
    float u0;
    float v0;
    float u1;
    float v1;
    uint color;   // RGBA8, linear, 0xffffffff = white
};

// A run of triangles with one opacity class. 32 bytes.
struct Mesh {
    uint firstTriangle;
    uint triangleCount;
    uint firstVertex;
    uint vertexCount;
    uint opacity;      // OPACITY_*
    uint hasTangents;  // 0 or 1
    uint root;         // root node of its tree in devices that own one
    uint pad0;
};
UINT_CONSTANT(OPACITY_OPAQUE, 0u)
UINT_CONSTANT(OPACITY_MASKED, 1u)       // needs an alpha test
UINT_CONSTANT(OPACITY_TRANSPARENT, 2u)  // passes light: blend or transmission

// A placed mesh or shape: 3x4 affine rows, 112 bytes. Rows hold (m0, m1, m2, translation).
struct Instance {
    vec4 toWorld0;
    vec4 toWorld1;
    vec4 toWorld2;
    vec4 toObject0;
    vec4 toObject1;
    vec4 toObject2;
    uint mesh;
    uint flags;          // INSTANCE_*
    uint firstTriangle;  // copy of the mesh's, saves a load
    uint root;           // copy of the mesh's
};
UINT_CONSTANT(INSTANCE_IDENTITY, 1u)  // transform is the identity
UINT_CONSTANT(INSTANCE_MIRRORED, 2u)  // determinant < 0: winding flips
UINT_CONSTANT(INSTANCE_SHAPE, 4u)     // no triangles but a formula: see effects/shapes.glsl
UINT_CONSTANT(SHAPE_POLE, 8u)         // of a sphere: its space begins at a point of its surface, not in its middle
UINT_CONSTANT(SHAPE_CAPPED, 16u)      // of a cylinder: it is closed
UINT_CONSTANT(SHAPE_KIND, 32u)        // times SHAPE_*
UINT_CONSTANT(SHAPE_OPACITY, 128u)    // times OPACITY_*
UINT_CONSTANT(SHAPE_SPHERE, 0u)
UINT_CONSTANT(SHAPE_CYLINDER, 1u)
UINT_CONSTANT(SHAPE_DISC, 2u)
UINT_CONSTANT(SHAPE_PLANE, 3u)

// One material for MTL and glTF alike, 176 bytes. Texture fields index TextureSlot, NO_INDEX = none.
struct Material {
    vec4 baseColor;    // rgb diffuse or base colour, a = alpha
    vec4 emission;     // rgb radiance, w = density of sampled points on its surface as a lamp, per m^2 (SceneBuilder's)
    vec4 specular;     // Phong: rgb Ks, w = Ns. Metallic-roughness: rgb specular colour (1), w = 1 - specular factor
    vec4 absorption;   // rgb coefficient per metre (Beer-Lambert), w unused
    vec4 transmissionTint;  // rgb colour of transmitted light at the surface (MTL Tf), w unused
    float metallic;
    float roughness;
    float transmission;  // share of the light not reflected that passes the surface
    float ior;
    float mirror;        // Phong: constant reflectance (RayEngine's Ir, or Ks of a mirror illum), 0 = none
    float alphaCutoff;
    float normalScale;
    float occlusionStrength;   // of occlusionTexture, in [0, 1]
    uint flags;          // MATERIAL_*
    uint baseTexture;
    uint metallicRoughnessTexture;
    uint normalTexture;
    uint emissionTexture;
    uint opacityTexture;       // MTL map_d
    uint transmissionTexture;  // red channel
    uint specularTexture;      // MTL map_Ks
    uint occlusionTexture;     // red channel: share of the ambient light that arrives
    uint medium;         // number of the medium inside, 1 to 127, the greater one wins where bodies overlap; 0: none
    uint mediumMaterial; // of material i: the one that stands for the medium i + 1. Both SceneBuilder's
    int priority;        // of its bodies over others, as the file says
    uint layers;         // first texel of its layer_table.glsl, NO_INDEX = none
    uint pad0;
    uint pad1;
    uint pad2;
};

// A texture as a material uses it: image, uv set and KHR_texture_transform. 48 bytes.
struct TextureSlot {
    vec4 transform;  // (m00, m01, m10, m11): u' = m00 u + m01 v + offset.x
    vec2 offset;
    uint image;
    uint uvSet;      // 0 or 1
    uint wrapU;      // WRAP_*
    uint wrapV;
    uint nearest;    // 1 = no filtering
    uint pad0;
};
UINT_CONSTANT(WRAP_REPEAT, 0u)
UINT_CONSTANT(WRAP_CLAMP, 1u)
UINT_CONSTANT(WRAP_MIRROR, 2u)

// A mip pyramid in the texel array. 16 bytes.
struct Image {
    uint firstLevel;  // index into imageLevels
    uint levelCount;
    uint format;      // IMAGE_*
    uint pad0;
};
UINT_CONSTANT(IMAGE_SRGB8, 0u)    // RGBA8, colour is sRGB coded
UINT_CONSTANT(IMAGE_LINEAR8, 1u)  // RGBA8, linear
UINT_CONSTANT(IMAGE_RGB9E5, 2u)   // shared exponent, for environments

// One mip level: texel index of its first texel (row-major, top row first) and its size. 16 bytes.
struct ImageLevel {
    uint firstTexel;
    uint width;
    uint height;
    uint pad0;
};

UINT_CONSTANT(LIGHT_POINT, 0u)
UINT_CONSTANT(LIGHT_SPOT, 1u)
UINT_CONSTANT(LIGHT_DIRECTIONAL, 2u)
UINT_CONSTANT(LIGHT_HEADLIGHT, 3u)  // shines from the camera, no falloff
UINT_CONSTANT(LIGHT_QUAD, 4u)       // a rectangle that shines to the side it faces, with the cosine
UINT_CONSTANT(FALLOFF_INVERSE_SQUARE, 0u)
UINT_CONSTANT(FALLOFF_LINEAR, 1u)   // max(1 - d / range, 0), as RayEngine's lights

// 80 bytes.
struct Light {
    vec3 position;     // of a quad: its centre
    float range;       // 0 = unlimited
    vec3 direction;    // unit, the way the light travels (spot, directional, quad)
    float cosInner;
    vec3 intensity;    // point and spot: radiant intensity, quad: the same along its direction; directional: irradiance;
                       // linear falloff: irradiance at 0
    float cosOuter;
    uint type;
    uint falloff;
    float radius;      // point and spot: of the ball that shines; directional: tangent of the angular radius; 0 = a point
    uint pad0;
    vec3 edge;         // quad: from the centre to the middle of a side
    float aspect;      // quad: half length of that side over the length of `edge`
};

// What surrounds the scene, and the tables by which light is sampled (first words in the array of texels). 240 bytes. One of
// those that the scene has, turned and scaled for the frame (request/surroundings.h).
struct Environment {
    vec4 color;          // rgb mean radiance, used where there is no image
    uint image;          // RGB9E5 or SRGB8 lat-long image or NO_INDEX
    float intensity;     // multiplies the image
    float rotation;      // radians about +Y
    uint filtered;       // image whose levels are the lobes of FILTERED_ROUGHNESS steps, then irradiance / pi; or NO_INDEX
    vec4 ambient[9];     // order-2 spherical harmonics of irradiance / pi, already scaled
    uint lightTable;     // 3 words a direction: threshold, alias, density per steradian; of columns x rows
    uint lightColumns;   // 0: the image is not sampled as a light
    uint lightRows;
    uint emitterTable;   // 4 words a glowing triangle: threshold, alias, instance, primitive
    uint emitterCount;
    uint lightTree;        // root of the tree of the scene's many lights (scene/light/light_tree.h): a word of the texels
    uint lightTreeLevels;  // choices from the root to a light at most; 0: no tree
    uint listedLights;     // lights before those in the tree: asked one by one
    uint lampTree;         // the same for glowing triangles (scene/light/emitters.h)
    uint lampTreeLevels;   // 0: no tree, they are chosen by power alone
    uint lampTrails;       // word i: the parts that lead to entry i of emitterTable, LAMP_TRAIL_BITS a level from the root on
    uint glassTable;       // of glassLoss, where there is rough glass
    vec4 backdrop;         // seen behind the scene in the place of the image: w < 0, rgb radiance; w > 0, the image blurred by a
                           // cone of so many radians; 0, the image itself
};
UINT_CONSTANT(FILTERED_LEVELS, 10u)  // level i of Environment.filtered: the lobe of roughness (i + 1) / FILTERED_LEVELS
UINT_CONSTANT(LIGHT_TABLE_WORDS, 3u)
UINT_CONSTANT(EMITTER_TABLE_WORDS, 4u)
UINT_CONSTANT(MOST_LISTED_LIGHTS, 32u)      // with a place; more stand in a tree
UINT_CONSTANT(MOST_LISTED_LAMPS, 64u)       // glowing triangles; more stand in a tree
UINT_CONSTANT(LAMP_TRAIL_BITS, 3u)
UINT_CONSTANT(LIGHT_TREE_WIDTH, 8u)         // parts of a node
UINT_CONSTANT(LIGHT_TREE_WORDS, 12u)        // of a part: ball, cone of directions, strength and what it leads to
UINT_CONSTANT(LIGHT_TREE_LEAF, 0x80000000u) // the part is one light, whose words begin there

// A pinhole camera, ready for the kernel. Pixel (x, y) looks along forward + sx * right + sy * up, 64 bytes.
struct KernelCamera {
    vec3 origin;
    float pixelSpread;  // angle between neighbouring pixels, radians
    vec3 forward;       // unit
    uint media;         // bodies in which it stands, as effects/nested_media.glsl has them
    vec3 right;         // scaled by tan(fov/2) * aspect
    float pad1;
    vec3 up;            // scaled by tan(fov/2)
    float pad2;
};

// A ray. 32 bytes.
struct Ray {
    vec3 origin;
    float tMax;  // hits are looked for in (0, tMax)
    vec3 direction;  // unit
    float pad0;
};

// What a device answers: two indices and nothing else. Barycentrics and distance are recomputed in shared code, so that
// every device shades the same point.
struct Hit {
    uint instance;   // NO_INDEX = nothing hit
    uint primitive;  // triangle within the instance's mesh
};

// The frame's constants, the kernel's only input beside the scene.
struct FrameConstants {
    KernelCamera camera;
    uvec2 resolution;
    uint effects;     // EffectSet bits below 32
    uint lightCount;
    float aoDistance; // aoRadius setting times the scene's own radius, metres
    uint seed;
    float fogSigma;   // extinction per metre: the fogDensity setting over the scene's radius
    float fogRadius;  // metres; the fog is a ball about the scene
    vec3 fogCenter;
    float rayReach;   // largest |x| + |y| + |z| of a ray's origin, see isTraceable
    KernelCamera cameraBefore;  // a frame ago; the same as `camera` where nothing moves
    Light sun;                  // with EFFECT_SUN: the last of lightCount
#define SETTING_K_INT(name, group, acts, def, low, high, unit, label, effect, price, help) uint name;
#define SETTING_K_FLOAT(name, group, acts, def, low, high, unit, label, effect, price, help) float name;
#include "settings_table.glsl"
    uint layers;      // EffectSet bits from 32 on
    float groundHeight;  // with EFFECT_GROUND: y of the plane
};

#endif

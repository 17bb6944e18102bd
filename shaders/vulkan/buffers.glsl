// The scene's buffers as GLSL sees them, and the names by which the kernel reads them (kernel.h has the C++ twins).
// What is the same for every point are uniform blocks; the arrays are storage buffers, or texel buffers (fetch.glsl) where
// the including file defines FETCH_ARRAYS.
#ifndef HELIOGRAPH_BUFFERS_GLSL
#define HELIOGRAPH_BUFFERS_GLSL

#include "vulkan/bindings.glsl"

layout(std140, set = 0, binding = BINDING_FRAME) uniform FrameData {
    FrameConstants frameConstants;
    Environment environmentData;
};
#define FRAME frameConstants
#define ENVIRONMENT environmentData

#ifdef FETCH_ARRAYS
#include "vulkan/fetch.glsl"
#else

layout(std430, set = 0, binding = BINDING_POSITIONS) readonly buffer PositionBuffer { vec4 positions[]; };
layout(std430, set = 0, binding = BINDING_ATTRIBUTES) readonly buffer AttributeBuffer { VertexAttributes vertexAttributes[]; };
layout(std430, set = 0, binding = BINDING_TANGENTS) readonly buffer TangentBuffer { vec4 tangents[]; };
layout(std430, set = 0, binding = BINDING_TRIANGLES) readonly buffer TriangleBuffer { uvec4 triangles[]; };
layout(std430, set = 0, binding = BINDING_MESHES) readonly buffer MeshBuffer { Mesh meshes[]; };
layout(std430, set = 0, binding = BINDING_INSTANCES) readonly buffer InstanceBuffer { Instance instances[]; };
layout(std430, set = 0, binding = BINDING_MATERIALS) readonly buffer MaterialBuffer { Material materials[]; };
layout(std430, set = 0, binding = BINDING_TEXTURES) readonly buffer TextureBuffer { TextureSlot textureSlots[]; };
layout(std430, set = 0, binding = BINDING_IMAGES) readonly buffer ImageBuffer { Image images[]; };
layout(std430, set = 0, binding = BINDING_IMAGE_LEVELS) readonly buffer ImageLevelBuffer { ImageLevel imageLevels[]; };
layout(std430, set = 0, binding = BINDING_TEXELS) readonly buffer TexelBuffer { uint texels[]; };
layout(std430, set = 0, binding = BINDING_LIGHTS) readonly buffer LightBuffer { Light lights[]; };
layout(std430, set = 0, binding = BINDING_SOBOL) readonly buffer SobolBuffer { uvec2 sobolPoints[]; };

#define POSITION(i) positions[i]
#define ATTRIBUTE(i, field) vertexAttributes[i].field
#define TANGENT(i) tangents[i]
#define TRIANGLE(i) triangles[i]
#define NORMAL_U(i) vec4(vertexAttributes[i].normal, vertexAttributes[i].u0)
#define MESH(i, field) meshes[i].field
#define INSTANCE(i, field) instances[i].field
#define MATERIAL(i, field) materials[i].field
#define TEXTURE(i, field) textureSlots[i].field
#define IMAGE(i, field) images[i].field
#define IMAGE_LEVEL(i) uvec4(imageLevels[i].firstTexel, imageLevels[i].width, imageLevels[i].height, 0u)
#define TEXEL(i) texels[i]
#define TEXEL_ROW(i) uvec4(texels[i], texels[(i) + 1u], texels[(i) + 2u], texels[(i) + 3u])
#define LIGHT(i) lights[i]
#define SOBOL(i) sobolPoints[i]
#define SOBOL_AT(i) sobolPoints[i]

#endif
#endif

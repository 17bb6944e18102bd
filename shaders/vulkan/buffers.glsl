// The scene's buffers as GLSL sees them, and the names by which the kernel reads them (kernel.h has the C++ twins).
// What is the same for every point are uniform blocks; the arrays are storage buffers, or texel buffers (fetch.glsl) where
// the including file defines FETCH_ARRAYS.
#ifndef HELIOGRAPH_BUFFERS_GLSL
#define HELIOGRAPH_BUFFERS_GLSL

layout(std140, set = 0, binding = 0) uniform FrameBlock { FrameConstants frameConstants; };
layout(std140, set = 0, binding = 13) uniform EnvironmentBlock { Environment environmentData; };
#define FRAME frameConstants
#define ENVIRONMENT environmentData

#ifdef FETCH_ARRAYS
#include "vulkan/fetch.glsl"
#else

layout(std430, set = 0, binding = 1) readonly buffer PositionBuffer { vec4 positions[]; };
layout(std430, set = 0, binding = 2) readonly buffer AttributeBuffer { VertexAttributes vertexAttributes[]; };
layout(std430, set = 0, binding = 3) readonly buffer TangentBuffer { vec4 tangents[]; };
layout(std430, set = 0, binding = 4) readonly buffer TriangleBuffer { uvec4 triangles[]; };
layout(std430, set = 0, binding = 5) readonly buffer MeshBuffer { Mesh meshes[]; };
layout(std430, set = 0, binding = 6) readonly buffer InstanceBuffer { Instance instances[]; };
layout(std430, set = 0, binding = 7) readonly buffer MaterialBuffer { Material materials[]; };
layout(std430, set = 0, binding = 8) readonly buffer TextureBuffer { TextureSlot textureSlots[]; };
layout(std430, set = 0, binding = 9) readonly buffer ImageBuffer { Image images[]; };
layout(std430, set = 0, binding = 10) readonly buffer ImageLevelBuffer { ImageLevel imageLevels[]; };
layout(std430, set = 0, binding = 11) readonly buffer TexelBuffer { uint texels[]; };
layout(std430, set = 0, binding = 12) readonly buffer LightBuffer { Light lights[]; };
layout(std430, set = 0, binding = 14) readonly buffer SobolBuffer { uvec2 sobolPoints[]; };

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
#define LIGHT(i) lights[i]
#define SOBOL(i) sobolPoints[i]
#define SOBOL_AT(i) sobolPoints[i]

#endif
#endif

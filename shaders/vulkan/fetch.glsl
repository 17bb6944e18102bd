// The scene's arrays as texel buffers, by the names of buffers.glsl. CPU-type devices run one program on several points at a
// time and read storage buffers point by point and word by word, texel buffers by rows of 16 bytes for all points at once.

#define FETCHED(number, name) layout(set = 0, binding = number) uniform usamplerBuffer name;
FETCHED(BINDING_POSITIONS, fetchPositions)
FETCHED(BINDING_ATTRIBUTES, fetchVertexAttributes)
FETCHED(BINDING_TANGENTS, fetchTangents)
FETCHED(BINDING_TRIANGLES, fetchTriangles)
FETCHED(BINDING_MESHES, fetchMesh)
FETCHED(BINDING_INSTANCES, fetchInstance)
FETCHED(BINDING_MATERIALS, fetchMaterial)
FETCHED(BINDING_TEXTURES, fetchTextureSlot)
FETCHED(BINDING_IMAGES, fetchImage)
FETCHED(BINDING_IMAGE_LEVELS, fetchImageLevels)
FETCHED(BINDING_TEXELS, fetchTexels)
FETCHED(BINDING_LIGHTS, fetchLights)
FETCHED(BINDING_SOBOL, fetchSobol)

// Row `row` of element i of an array whose elements have `rows` rows.
#define ROW(array, i, rows, row) texelFetch(array, int((i) * rows + row))
#define ROWF(array, i, rows, row) uintBitsToFloat(ROW(array, i, rows, row))

#define POSITION(i) ROWF(fetchPositions, i, 1u, 0u)
#define TANGENT(i) ROWF(fetchTangents, i, 1u, 0u)
#define TRIANGLE(i) ROW(fetchTriangles, i, 1u, 0u)
#define NORMAL_U(i) ROWF(fetchVertexAttributes, i, ROWS_VertexAttributes, 0u)
#define IMAGE_LEVEL(i) ROW(fetchImageLevels, i, 1u, 0u)
#define TEXEL(i) texelFetch(fetchTexels, int(i)).x
#define TEXEL_ROW(i) uvec4(TEXEL(i), TEXEL((i) + 1u), TEXEL((i) + 2u), TEXEL((i) + 3u))
#define SOBOL(i) texelFetch(fetchSobol, int(i)).xy
#define SOBOL_AT(i) SOBOL(i)

#define FETCH_ROW(T, field, row) vec4 T##_##field(uint i) { return ROWF(fetch##T, i, ROWS_##T, row); }
#define FETCH_PAIR(T, field, row) vec2 T##_##field(uint i) { return ROWF(fetch##T, i, ROWS_##T, row).xy; }
#define FETCH_FLOAT(T, field, row, component) float T##_##field(uint i) { return ROWF(fetch##T, i, ROWS_##T, row).component; }
#define FETCH_UINT(T, field, row, component) uint T##_##field(uint i) { return ROW(fetch##T, i, ROWS_##T, row).component; }
#include "vulkan/fetch_table.glsl"

#define ATTRIBUTE(i, field) VertexAttributes_##field(i)
#define MESH(i, field) Mesh_##field(i)
#define INSTANCE(i, field) Instance_##field(i)
#define MATERIAL(i, field) Material_##field(i)
#define TEXTURE(i, field) TextureSlot_##field(i)
#define IMAGE(i, field) Image_##field(i)

Light fetchLight(uint i) {
    vec4 position = ROWF(fetchLights, i, 5u, 0u);
    vec4 direction = ROWF(fetchLights, i, 5u, 1u);
    vec4 intensity = ROWF(fetchLights, i, 5u, 2u);
    uvec4 kind = ROW(fetchLights, i, 5u, 3u);
    vec4 edge = ROWF(fetchLights, i, 5u, 4u);
    return Light(position.xyz, position.w, direction.xyz, direction.w, intensity.xyz, intensity.w, kind.x, kind.y,
                 uintBitsToFloat(kind.z), 0u, edge.xyz, edge.w);
}
#define LIGHT(i) fetchLight(i)

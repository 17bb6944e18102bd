// The scene's arrays as texel buffers, by the names of buffers.glsl. CPU-type devices run one program on several points at a
// time and read storage buffers point by point and word by word, texel buffers by rows of 16 bytes for all points at once.
// Rows and components follow the structs of types.glsl.

#define FETCHED(number, name) layout(set = 0, binding = number) uniform usamplerBuffer name;
FETCHED(1, fetchPositions)
FETCHED(2, fetchAttributes)
FETCHED(3, fetchTangents)
FETCHED(4, fetchTriangles)
FETCHED(5, fetchMeshes)
FETCHED(6, fetchInstances)
FETCHED(7, fetchMaterials)
FETCHED(8, fetchTextures)
FETCHED(9, fetchImages)
FETCHED(10, fetchImageLevels)
FETCHED(11, fetchTexels)
FETCHED(12, fetchLights)
FETCHED(14, fetchSobol)

// Row `row` of element i of an array whose elements have `rows` rows.
#define ROW(array, i, rows, row) texelFetch(array, int((i) * rows + row))
#define ROWF(array, i, rows, row) uintBitsToFloat(ROW(array, i, rows, row))

#define POSITION(i) ROWF(fetchPositions, i, 1u, 0u)
#define TANGENT(i) ROWF(fetchTangents, i, 1u, 0u)
#define TRIANGLE(i) ROW(fetchTriangles, i, 1u, 0u)
#define NORMAL_U(i) ROWF(fetchAttributes, i, 2u, 0u)
#define IMAGE_LEVEL(i) ROW(fetchImageLevels, i, 1u, 0u)
#define TEXEL(i) texelFetch(fetchTexels, int(i)).x
#define SOBOL(i) texelFetch(fetchSobol, int(i)).xy
#define SOBOL_AT(i) SOBOL(i)

#define ATTRIBUTE(i, field) ATTRIBUTE_##field(i)
#define ATTRIBUTE_v0(i) ROWF(fetchAttributes, i, 2u, 1u).x
#define ATTRIBUTE_u1(i) ROWF(fetchAttributes, i, 2u, 1u).y
#define ATTRIBUTE_v1(i) ROWF(fetchAttributes, i, 2u, 1u).z
#define ATTRIBUTE_color(i) ROW(fetchAttributes, i, 2u, 1u).w

#define MESH(i, field) MESH_##field(i)
#define MESH_hasTangents(i) ROW(fetchMeshes, i, 2u, 1u).y

#define INSTANCE(i, field) INSTANCE_##field(i)
#define INSTANCE_toWorld0(i) ROWF(fetchInstances, i, 7u, 0u)
#define INSTANCE_toWorld1(i) ROWF(fetchInstances, i, 7u, 1u)
#define INSTANCE_toWorld2(i) ROWF(fetchInstances, i, 7u, 2u)
#define INSTANCE_toObject0(i) ROWF(fetchInstances, i, 7u, 3u)
#define INSTANCE_toObject1(i) ROWF(fetchInstances, i, 7u, 4u)
#define INSTANCE_toObject2(i) ROWF(fetchInstances, i, 7u, 5u)
#define INSTANCE_mesh(i) ROW(fetchInstances, i, 7u, 6u).x
#define INSTANCE_flags(i) ROW(fetchInstances, i, 7u, 6u).y
#define INSTANCE_firstTriangle(i) ROW(fetchInstances, i, 7u, 6u).z
#define INSTANCE_root(i) ROW(fetchInstances, i, 7u, 6u).w

#define MATERIAL(i, field) MATERIAL_##field(i)
#define MATERIAL_baseColor(i) ROWF(fetchMaterials, i, 9u, 0u)
#define MATERIAL_emission(i) ROWF(fetchMaterials, i, 9u, 1u)
#define MATERIAL_specular(i) ROWF(fetchMaterials, i, 9u, 2u)
#define MATERIAL_absorption(i) ROWF(fetchMaterials, i, 9u, 3u)
#define MATERIAL_transmissionTint(i) ROWF(fetchMaterials, i, 9u, 4u)
#define MATERIAL_metallic(i) ROWF(fetchMaterials, i, 9u, 5u).x
#define MATERIAL_roughness(i) ROWF(fetchMaterials, i, 9u, 5u).y
#define MATERIAL_transmission(i) ROWF(fetchMaterials, i, 9u, 5u).z
#define MATERIAL_ior(i) ROWF(fetchMaterials, i, 9u, 5u).w
#define MATERIAL_mirror(i) ROWF(fetchMaterials, i, 9u, 6u).x
#define MATERIAL_alphaCutoff(i) ROWF(fetchMaterials, i, 9u, 6u).y
#define MATERIAL_normalScale(i) ROWF(fetchMaterials, i, 9u, 6u).z
#define MATERIAL_flags(i) ROW(fetchMaterials, i, 9u, 7u).x
#define MATERIAL_baseTexture(i) ROW(fetchMaterials, i, 9u, 7u).y
#define MATERIAL_metallicRoughnessTexture(i) ROW(fetchMaterials, i, 9u, 7u).z
#define MATERIAL_normalTexture(i) ROW(fetchMaterials, i, 9u, 7u).w
#define MATERIAL_emissionTexture(i) ROW(fetchMaterials, i, 9u, 8u).x
#define MATERIAL_opacityTexture(i) ROW(fetchMaterials, i, 9u, 8u).y
#define MATERIAL_transmissionTexture(i) ROW(fetchMaterials, i, 9u, 8u).z
#define MATERIAL_specularTexture(i) ROW(fetchMaterials, i, 9u, 8u).w

#define TEXTURE(i, field) TEXTURE_##field(i)
#define TEXTURE_transform(i) ROWF(fetchTextures, i, 3u, 0u)
#define TEXTURE_offset(i) ROWF(fetchTextures, i, 3u, 1u).xy
#define TEXTURE_image(i) ROW(fetchTextures, i, 3u, 1u).z
#define TEXTURE_uvSet(i) ROW(fetchTextures, i, 3u, 1u).w
#define TEXTURE_wrapU(i) ROW(fetchTextures, i, 3u, 2u).x
#define TEXTURE_wrapV(i) ROW(fetchTextures, i, 3u, 2u).y
#define TEXTURE_nearest(i) ROW(fetchTextures, i, 3u, 2u).z

#define IMAGE(i, field) IMAGE_##field(i)
#define IMAGE_firstLevel(i) ROW(fetchImages, i, 1u, 0u).x
#define IMAGE_levelCount(i) ROW(fetchImages, i, 1u, 0u).y
#define IMAGE_format(i) ROW(fetchImages, i, 1u, 0u).z

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

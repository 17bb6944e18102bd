// One bounce of indirect light: the diffuse part of a surface looks along one ray a sample, spread by the cosine, instead of
// taking the ambient light. What the ray meets is lit by the lights and glows; its own surroundings are the ambient light
// again. After Kajiya, "The Rendering Equation" (1986), cut after the first diffuse bounce.

UINT_CONSTANT(INDIRECT_SALT, 0x626f756eu)
UINT_CONSTANT(DIFFUSED, 0x00800000u)      // in PathState.depth: the path has bounced off a diffuse surface
FLOAT_CONSTANT(INDIRECT_SPREAD, 0.2f)     // radians; the ray stands for a wide cone, so textures take a coarse level

// Share of the light from all around that the diffuse part of a surface reflects towards wo.
vec3 diffuseAlbedo(IN(Shading) m, vec3 wo) {
    vec3 albedo = m.diffuse;
    bool phong = (m.flags & MATERIAL_PHONG) != 0u;
    if (ANY(!phong)) {
        float followed = traceableShare(m.roughness);
        float nDotV = saturate(dot(m.normal, wo));
        vec3 taken = environmentBrdf(m.f0, m.roughness, nDotV) * (1.0f - followed) + fresnelSchlick(m.f0, nDotV) * followed;
        albedo = SELECT(phong, albedo, albedo * (vec3(1.0f, 1.0f, 1.0f) - taken));
    }
    return albedo;
}

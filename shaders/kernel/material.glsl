// What a surface does with light: one model for MTL and glTF materials.

struct Shading {
    vec3 normal;        // unit, with normal map, towards the viewer
    vec3 diffuse;       // diffuse albedo, what mirrors, transmission and the specular lobe (seenFrom) take already taken off
    vec3 emission;      // radiance
    vec3 f0;            // reflectance at normal incidence (metallic-roughness) or Ks (Phong)
    float f90;          // the same at grazing incidence
    vec3 albedo;        // of the specular lobe, seen from where the path comes from (seenFrom)
    vec3 gain;          // of the specular lobe, for light that bounces between facets
    vec3 tint;          // colour of transmitted light
    float roughness;
    float exponent;     // Phong Ns, 0 = no highlight
    float alpha;        // 1 = solid; the rest passes straight on
    float transmission; // share of the light not reflected that passes
    float mirror;       // Phong: constant reflectance
    float ior;
    float occlusion;    // share of the ambient light that arrives; by images alone
    uint flags;         // MATERIAL_*
    vec3 facet;         // unit, about which it reflects: the normal, or what reflectingNormal chooses
    // What follows holds something with the effect of its layer alone (HAS_LAYER).
    float kept;         // share of the light that the coat leaves to all under it
    float coat;
    float coatRoughness;
    float coatAlbedo;   // of the coat, seen from where the path comes from
    vec3 coatNormal;    // unit
    vec3 sheen;         // colour, what the coat takes already taken off
    vec3 sheenAlbedo;   // of the sheen, seen from where the path comes from
    float sheenRoughness;
    uint sheenTable;
    vec3 tangent;       // unit: the long way of the specular lobe, and
    vec3 bitangent;     // the short one
    float widthAlong;
    float widthAcross;
    float film;
    float filmIor;
    float filmThickness;  // nanometres
    vec3 through;       // diffuse albedo of light that comes out on the other side
};

// Slope of a height image: three heights one texel apart; y runs against v, as in normal maps. Blinn, "Simulation of Wrinkled Surfaces" (1978).
vec3 bumpNormal(IN(Surface) s, uint slot, float scale) {
    uint image = TEXTURE(slot, image);
    uvec4 level = IMAGE_LEVEL(IMAGE(image, firstLevel));
    vec2 du = vec2(1.0f / float(int(level.y)), 0.0f);
    vec2 dv = vec2(0.0f, 1.0f / float(int(level.z)));
    float h = sampleTexture(slot, s.uv0, s.uv1, s.footprint, s.ellipse).x;
    float hu = sampleTexture(slot, s.uv0 + du, s.uv1 + du, s.footprint, s.ellipse).x;
    float hv = sampleTexture(slot, s.uv0 + dv, s.uv1 + dv, s.footprint, s.ellipse).x;
    return vec3((h - hu) * scale, (hv - h) * scale, 0.25f);
}

// Tangent of the uv and what completes it and the interpolated normal, both unit; false where the triangle has no such frame.
bool tangentFrame(IN(Surface) s, OUT(vec3) t, OUT(vec3) bitangent) {
    vec3 tangent = vec3(0.0f, 0.0f, 0.0f);
    float handedness = 1.0f;
    if (HAS(EFFECT_TEXTURES)) {  // else there are no coordinates
        // Without tangents in the file: the uv frame of the triangle.
        float det = s.uvEdge1.x * s.uvEdge2.y - s.uvEdge1.y * s.uvEdge2.x;
        float turn = SELECT(det < 0.0f, -1.0f, 1.0f);
        tangent = (s.edge1 * s.uvEdge2.y - s.edge2 * s.uvEdge1.y) * turn;
        handedness = -turn;  // the bitangent runs against v, as glTF has it
    }
    if (HAS(EFFECT_TANGENTS)) {
        bool given = s.tangentSign != 0.0f;
        tangent = SELECT(given, s.tangent, tangent);
        handedness = SELECT(given, s.tangentSign, handedness);
    }
    t = tangent - s.normal * dot(tangent, s.normal);
    float tt = dot(t, t);
    bool usable = tt > 1.0e-20f;
    t = t * (1.0f / sqrt(SELECT(usable, tt, 1.0f)));
    bitangent = cross(s.normal, t) * (handedness * s.side);
    return usable;
}

// The normal map's normal in world space, kept above the geometric surface.
vec3 mappedNormal(IN(Surface) s, uint slot, float scale, uint flags) {
    vec3 t;
    vec3 bitangent;
    bool usable = tangentFrame(s, t, bitangent);
    vec4 texel = sampleTexture(slot, s.uv0, s.uv1, s.footprint, s.ellipse);
    vec3 local = vec3((texel.x * 2.0f - 1.0f) * scale, (texel.y * 2.0f - 1.0f) * scale, texel.z * 2.0f - 1.0f);
    bool bump = (flags & MATERIAL_BUMP) != 0u;
    if (MET(VARIETY_BUMP) && ANY(bump)) local = SELECT(bump, bumpNormal(s, slot, scale), local);
    vec3 n = normalize3(t * local.x + bitangent * local.y + s.normal * local.z);
    return SELECT(usable && dot(n, s.geometricNormal) > 0.01f, n, s.normal);
}

// Opacity from map_d: red or alpha.
float opacityAt(IN(Surface) s, uint slot, uint flags) {
    vec4 texel = sampleTexture(slot, s.uv0, s.uv1, s.footprint, s.ellipse);
    return SELECT((flags & MATERIAL_OPACITY_RED) != 0u, texel.x, texel.w);
}

// Share of the ambient light that the image lets arrive (glTF 2.0, section 3.9.3).
float occlusionAt(IN(Surface) s, uint slot) {
    return 1.0f + MATERIAL(s.material, occlusionStrength) * (sampleTexture(slot, s.uv0, s.uv1, s.footprint, s.ellipse).x - 1.0f);
}

// `ambient`, less what the image keeps away.
vec3 ambientArriving(IN(Shading) m, vec3 ambient) {
    if (HAS(EFFECT_OCCLUSION_TEXTURES)) return ambient * m.occlusion;
    return ambient;
}

// Base colour and alpha with vertex colours and textures.
vec4 baseColorAt(IN(Surface) s, uint flags) {
    vec4 base = MATERIAL(s.material, baseColor);
    if (HAS(EFFECT_VERTEX_COLORS)) base = base * s.color;
    if (HAS(EFFECT_TEXTURES)) {
        uint slot = MATERIAL(s.material, baseTexture);
        if (MET(VARIETY_BASE_TEXTURE) && ANY(slot != NO_INDEX)) base = base * sampleTexture(slot, s.uv0, s.uv1, s.footprint, s.ellipse);
        uint opacitySlot = MATERIAL(s.material, opacityTexture);
        bool masked = opacitySlot != NO_INDEX;
        if (MET(VARIETY_OPACITY_TEXTURE) && ANY(masked)) base.w = SELECT(masked, base.w * opacityAt(s, opacitySlot, flags), base.w);
    }
    return base;
}

// True where a cut-out has a hole: what the intersection filters of the devices ask.
bool isCutOut(IN(Surface) s) {
    uint flags = MATERIAL(s.material, flags);
    return (flags & MATERIAL_ALPHA_MASK) != 0u && baseColorAt(s, flags).w < MATERIAL(s.material, alphaCutoff);
}

void applyTextures(INOUT(Shading) r, INOUT(float) metallic, IN(Surface) s) {
    uint metallicRoughness = MATERIAL(s.material, metallicRoughnessTexture);
    if (MET(VARIETY_METALLIC_ROUGHNESS_TEXTURE) && ANY(metallicRoughness != NO_INDEX)) {
        vec4 texel = sampleTexture(metallicRoughness, s.uv0, s.uv1, s.footprint, s.ellipse);
        r.roughness = r.roughness * texel.y;
        metallic = metallic * texel.z;
    }
    uint transmission = MATERIAL(s.material, transmissionTexture);
    if (MET(VARIETY_TRANSMISSION_TEXTURE) && ANY(transmission != NO_INDEX))
        r.transmission = r.transmission * sampleTexture(transmission, s.uv0, s.uv1, s.footprint, s.ellipse).x;
    uint specular = MATERIAL(s.material, specularTexture);
    if (MET(VARIETY_SPECULAR_TEXTURE) && ANY(specular != NO_INDEX)) r.f0 = r.f0 * pointOf(sampleTexture(specular, s.uv0, s.uv1, s.footprint, s.ellipse));
    uint emission = MATERIAL(s.material, emissionTexture);
    if (HAS(EFFECT_EMISSION)) {
        if (MET(VARIETY_EMISSION_TEXTURE) && ANY(emission != NO_INDEX)) r.emission = r.emission * pointOf(sampleTexture(emission, s.uv0, s.uv1, s.footprint, s.ellipse));
    }
    if (HAS(EFFECT_OCCLUSION_TEXTURES)) {
        uint occlusion = MATERIAL(s.material, occlusionTexture);
        if (ANY(occlusion != NO_INDEX)) r.occlusion = occlusionAt(s, occlusion);
        // Rays that find out what hides the surroundings would count it twice.
        if (HAS(EFFECT_AMBIENT_OCCLUSION | EFFECT_PATH)) r.occlusion = 1.0f;
    }
    if (HAS(EFFECT_NORMAL_MAPS)) {
        uint normal = MATERIAL(s.material, normalTexture);
        bool mapped = normal != NO_INDEX;
        if (ANY(mapped)) {
            vec3 n = mappedNormal(s, SELECT(mapped, normal, uint(0u)), MATERIAL(s.material, normalScale), r.flags);
            r.normal = SELECT(mapped, n, r.normal);
        }
    }
}

#define MATERIAL_LAYERS \
    (EFFECT_CLEARCOAT | EFFECT_SHEEN | EFFECT_ANISOTROPY | EFFECT_IRIDESCENCE | EFFECT_DIFFUSE_TRANSMISSION)

#include "effects/material_layers.glsl"
#include "effects/anisotropy.glsl"
#include "effects/clearcoat.glsl"
#include "effects/diffuse_transmission.glsl"
#include "effects/iridescence.glsl"
#include "effects/sheen.glsl"

// What lies over the base. `kept`: share of the diffuse colour that metal and transmission leave.
void addLayers(INOUT(Shading) r, IN(Surface) s, float kept) {
    uint layers = SELECT((r.flags & MATERIAL_UNLIT) != 0u, uint(NO_INDEX), MATERIAL(s.material, layers));
    r.kept = 1.0f;
    if (HAS_LAYER(EFFECT_ANISOTROPY)) addAnisotropy(r, s, layers);
    if (HAS_LAYER(EFFECT_IRIDESCENCE)) addFilm(r, s, layers);
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) addThrough(r, s, layers, kept);
    if (HAS_LAYER(EFFECT_SHEEN)) addSheen(r, s, layers);
    if (HAS_LAYER(EFFECT_CLEARCOAT)) addCoat(r, s, layers);
}

// `ior`: index of the inner side over that of the outer.
Shading shadingWith(IN(Surface) s, float ior) {
    Shading r;
    r.flags = MATERIAL(s.material, flags);
    r.roughness = MATERIAL(s.material, roughness);
    float metallic = MATERIAL(s.material, metallic);
    r.transmission = MATERIAL(s.material, transmission);
    vec4 specular = MATERIAL(s.material, specular);
    r.f0 = pointOf(specular);
    r.exponent = specular.w;
    r.emission = vec3(0.0f, 0.0f, 0.0f);
    if (HAS(EFFECT_EMISSION)) r.emission = pointOf(MATERIAL(s.material, emission));
    r.normal = s.normal;
    r.occlusion = 1.0f;
    vec4 base = baseColorAt(s, r.flags);
    if (HAS(EFFECT_TEXTURES)) applyTextures(r, metallic, s);
    r.ior = ior;
    r.mirror = MATERIAL(s.material, mirror);
    r.alpha = 1.0f;
    if (HAS(EFFECT_ALPHA_BLEND)) r.alpha = SELECT((r.flags & MATERIAL_ALPHA_BLEND) != 0u, saturate(base.w), 1.0f);
    vec3 color = pointOf(base);
    r.tint = pointOf(MATERIAL(s.material, transmissionTint));
    // glTF 2.0, appendix B: dielectrics reflect ((ior - 1) / (ior + 1))^2, metals their base colour. ior 0 stands for a
    // surface that reflects everything (KHR_materials_ior).
    bool phong = (r.flags & MATERIAL_PHONG) != 0u;
    float k = (r.ior - 1.0f) / (r.ior + 1.0f);
    float dielectric = SELECT(r.ior > 0.0f, k * k, 1.0f);
    // KHR_materials_specular: the colour scales the reflectance straight on, the factor all of the reflection. What is seen flat
    // reflects white, whatever the colour.
    vec3 base0 = r.f0 * dielectric;
    base0 = vec3(min(base0.x, 1.0f), min(base0.y, 1.0f), min(base0.z, 1.0f));
    float dielectricShare = (1.0f - specular.w) * (1.0f - metallic);
    r.f90 = grazingReflectance(vec3(dielectric, dielectric, dielectric)) * dielectricShare + grazingReflectance(color) * metallic;
    r.f0 = SELECT(phong, r.f0, base0 * dielectricShare + color * metallic);
    r.tint = SELECT(phong, r.tint, r.tint * color);
    r.transmission = SELECT(phong, r.transmission, r.transmission * (1.0f - metallic));
    float kept = SELECT(phong, 1.0f - r.mirror, 1.0f - metallic);
    r.diffuse = color * (kept * (1.0f - r.transmission));
    if (HAS_LAYER(MATERIAL_LAYERS)) addLayers(r, s, kept * (1.0f - r.transmission));
    bool unlit = (r.flags & MATERIAL_UNLIT) != 0u;
    if (MET(VARIETY_UNLIT) && ANY(unlit)) {
        vec3 black = vec3(0.0f, 0.0f, 0.0f);
        r.emission = SELECT(unlit, r.emission + color, r.emission);
        r.diffuse = SELECT(unlit, black, r.diffuse);
        r.f0 = SELECT(unlit, black, r.f0);
        r.transmission = SELECT(unlit, 0.0f, r.transmission);
        r.mirror = SELECT(unlit, 0.0f, r.mirror);
        r.exponent = SELECT(unlit, 0.0f, r.exponent);
        r.flags = SELECT(unlit, r.flags | MATERIAL_PHONG, r.flags);  // the model that adds no Fresnel reflection
    }
    r.facet = r.normal;
    r.albedo = vec3(0.0f, 0.0f, 0.0f);
    r.gain = vec3(1.0f, 1.0f, 1.0f);
    return r;
}

// The same of a body in air.
Shading shadingAt(IN(Surface) s) { return shadingWith(s, MATERIAL(s.material, ior)); }

// Completes what depends on where a surface is seen from (wo, unit): the specular lobe's albedo, with the light that bounces
// between facets given back (Kulla & Conty, "Revisiting Physically Based Shading at Imageworks", 2017, as scaled by Turquin,
// "Practical Multiple Scattering Compensation for Microfacet Models", 2019), and the diffuse base under it, which gets what
// the lobe does not reflect.
void seenFrom(INOUT(Shading) m, vec3 wo) {
    bool microfacet = (m.flags & MATERIAL_PHONG) == 0u;
    if (MET(VARIETY_MICROFACET) && ANY(microfacet)) {
        if (HAS_LAYER(EFFECT_IRIDESCENCE)) seenThroughFilm(m, wo);
        float roughness = m.roughness;
        if (HAS_LAYER(EFFECT_ANISOTROPY)) roughness = SELECT(isBrushed(m), sqrt(widthOfLoss(m, dot(m.normal, wo))), roughness);
        vec2 lobe = lobeIntegrals(roughness, max(dot(m.normal, wo), 1.0e-4f));
        float lost = 1.0f / (lobe.x + lobe.y) - 1.0f;
        vec3 gain = vec3(1.0f + m.f0.x * lost, 1.0f + m.f0.y * lost, 1.0f + m.f0.z * lost);
        float flat_ = m.f90 * lobe.y;
        vec3 albedo = (m.f0 * lobe.x + vec3(flat_, flat_, flat_)) * gain;
        m.gain = SELECT(microfacet, gain, m.gain);
        m.albedo = SELECT(microfacet, albedo, m.albedo);
        vec3 left = vec3(max(1.0f - albedo.x, 0.0f), max(1.0f - albedo.y, 0.0f), max(1.0f - albedo.z, 0.0f));
        m.diffuse = SELECT(microfacet, m.diffuse * left, m.diffuse);
        if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) m.through = SELECT(microfacet, m.through * left, m.through);
    }
    if (HAS_LAYER(EFFECT_SHEEN)) seenThroughSheen(m, wo);
    if (HAS_LAYER(EFFECT_CLEARCOAT)) seenThroughCoat(m, wo);
}

// Distribution and visibility of the specular lobe; h half way between.
float specularLobe(IN(Shading) m, vec3 wo, vec3 wi, vec3 h, float nDotV, float nDotL) {
    float a = lobeWidth(m.roughness);
    float lobe = distributionGgx(saturate(dot(m.normal, h)), a) * visibilityGgx(nDotV, nDotL, a);
    if (HAS_LAYER(EFFECT_ANISOTROPY)) lobe = SELECT(isBrushed(m), lobeAlong(m, wo, wi, h, nDotV, nDotL), lobe);
    return lobe;
}

// Density per steradian with which a ray leaves by the facet whose normal is h.
float facetDensity(IN(Shading) m, vec3 wo, vec3 h) {
    float density = visibleDensity(max(dot(m.normal, wo), 1.0e-4f), saturate(dot(m.normal, h)), lobeWidth(m.roughness));
    if (HAS_LAYER(EFFECT_ANISOTROPY)) density = SELECT(isBrushed(m), densityAlong(m, wo, h), density);
    return density;
}

// What the diffuse lobes reflect and let through, as reflectedLight.
vec3 diffuseTowards(IN(Shading) m, vec3 wo, vec3 wi) {
    float nDotL = dot(m.normal, wi);
    vec3 result = m.diffuse * (max(nDotL, 0.0f) * INV_PI);
    if (HAS_LAYER(EFFECT_SHEEN)) result = result + sheenTowards(m, wo, wi);
    if (HAS_LAYER(EFFECT_DIFFUSE_TRANSMISSION)) result = result + m.through * (max(-nDotL, 0.0f) * INV_PI);
    return result;
}

// Reflected radiance per unit irradiance for light from wi seen from wo (unit vectors; see seenFrom), cosine included. Phong: the
// classical lobe, its peak 1 at any exponent, over pi so that Kd and Ks weigh alike.
vec3 baseTowards(IN(Shading) m, vec3 wo, vec3 wi) {
    float nDotL = max(dot(m.normal, wi), 0.0f);
    vec3 result = vec3(0.0f, 0.0f, 0.0f);
    bool phong = (m.flags & MATERIAL_PHONG) != 0u;
    if (MET(VARIETY_PHONG) && ANY(phong)) {
        vec3 r = m.normal * (2.0f * nDotL) - wi;
        float lobe = powKernel(saturate(dot(r, wo)), max(m.exponent, 1.0f));
        lobe = SELECT(m.exponent > 1.0f && nDotL > 0.0f, lobe, 0.0f);
        result = m.diffuse * (nDotL * INV_PI) + m.f0 * (lobe * INV_PI);
    }
    if (MET(VARIETY_MICROFACET) && ANY(!phong)) {
        vec3 h = normalize3(wo + wi);
        float nDotV = max(dot(m.normal, wo), 1.0e-4f);
        vec3 f = fresnelSchlick(m.f0, m.f90, saturate(dot(wo, h))) * m.gain;
        float lobe = specularLobe(m, wo, wi, h, nDotV, nDotL);
        vec3 microfacet = (m.diffuse * INV_PI + f * lobe) * nDotL;
        if (HAS_LAYER(EFFECT_SHEEN | EFFECT_DIFFUSE_TRANSMISSION)) microfacet = f * (lobe * nDotL) + diffuseTowards(m, wo, wi);
        result = SELECT(phong, result, microfacet);
    }
    return result;
}

// The same with what the coat adds.
vec3 reflectedLight(IN(Shading) m, vec3 wo, vec3 wi) {
    vec3 result = baseTowards(m, wo, wi);
    if (HAS_LAYER(EFFECT_CLEARCOAT)) {
        bool coated = m.coat > 0.0f;
        if (ANY(coated)) result = SELECT(coated, result + baseTowards(coatOf(m), wo, wi), result);
    }
    return result;
}

// How much of the specular reflection is followed by a mirror ray; the rest is rough and taken from the surroundings alone.
float traceableShare(float roughness) {
    float x = saturate((0.4f - roughness) * 5.0f);  // 1 up to 0.2, 0 from 0.4
    return x * x * (3.0f - 2.0f * x);
}

// What a surface does with light: one model for MTL and glTF materials.

struct Shading {
    vec3 normal;        // unit, with normal map, towards the viewer
    vec3 diffuse;       // diffuse albedo, what mirrors and transmission take already taken off
    vec3 emission;      // radiance
    vec3 f0;            // reflectance at normal incidence (metallic-roughness) or Ks (Phong)
    vec3 tint;          // colour of transmitted light
    float roughness;
    float exponent;     // Phong Ns, 0 = no highlight
    float alpha;        // 1 = solid; the rest passes straight on
    float transmission; // share of the light not reflected that passes
    float mirror;       // Phong: constant reflectance
    float ior;
    uint flags;         // MATERIAL_*
};

// The normal map's normal in world space, kept above the geometric surface.
vec3 mappedNormal(Surface s, Material material) {
    vec3 tangent = s.tangent;
    float handedness = s.tangentSign;
    if (handedness == 0.0f) {  // no tangents in the file: the uv frame of the triangle
        float det = s.uvEdge1.x * s.uvEdge2.y - s.uvEdge1.y * s.uvEdge2.x;
        tangent = (s.edge1 * s.uvEdge2.y - s.edge2 * s.uvEdge1.y) * (det < 0.0f ? -1.0f : 1.0f);
        handedness = det < 0.0f ? -1.0f : 1.0f;
    }
    vec3 t = tangent - s.normal * dot(tangent, s.normal);
    float tt = dot(t, t);
    if (!(tt > 1.0e-20f)) return s.normal;
    t = t * (1.0f / sqrt(tt));
    float side = s.frontFace != 0u ? 1.0f : -1.0f;
    vec3 bitangent = cross(s.normal, t) * (handedness * side);
    float x;
    float y;
    float z;
    if ((material.flags & MATERIAL_BUMP) != 0u) {
        // Slope from three heights one texel apart. Blinn, "Simulation of Wrinkled Surfaces" (1978).
        Image image = IMAGE(TEXTURE(material.normalTexture).image);
        ImageLevel level = IMAGE_LEVEL(image.firstLevel);
        vec2 du = vec2(1.0f / float(level.width), 0.0f);
        vec2 dv = vec2(0.0f, 1.0f / float(level.height));
        float h = sampleTexture(material.normalTexture, s.uv0, s.uv1, s.footprint).x;
        float hu = sampleTexture(material.normalTexture, s.uv0 + du, s.uv1 + du, s.footprint).x;
        float hv = sampleTexture(material.normalTexture, s.uv0 + dv, s.uv1 + dv, s.footprint).x;
        x = (h - hu) * material.normalScale;
        y = (h - hv) * material.normalScale;
        z = 0.25f;
    } else {
        vec4 texel = sampleTexture(material.normalTexture, s.uv0, s.uv1, s.footprint);
        x = (texel.x * 2.0f - 1.0f) * material.normalScale;
        y = (texel.y * 2.0f - 1.0f) * material.normalScale;
        z = texel.z * 2.0f - 1.0f;
    }
    vec3 n = normalize3(t * x + bitangent * y + s.normal * z);
    return dot(n, s.geometricNormal) > 0.01f ? n : s.normal;
}

// Alpha alone, for the visibility tests of cut-outs; also what the intersection filters of the devices call.
float alphaAt(Surface s) {
    Material material = MATERIAL(s.material);
    float alpha = material.baseColor.w;
    if (HAS(EFFECT_VERTEX_COLORS)) alpha = alpha * s.color.w;
    if (material.baseTexture != NO_INDEX) alpha = alpha * sampleTexture(material.baseTexture, s.uv0, s.uv1, s.footprint).w;
    if (material.opacityTexture != NO_INDEX) {
        vec4 texel = sampleTexture(material.opacityTexture, s.uv0, s.uv1, s.footprint);
        alpha = alpha * ((material.flags & MATERIAL_OPACITY_RED) != 0u ? texel.x : texel.w);
    }
    return alpha;
}

// True where a cut-out has a hole.
bool isCutOut(Surface s) {
    if ((MATERIAL(s.material).flags & MATERIAL_ALPHA_MASK) == 0u) return false;
    return alphaAt(s) < MATERIAL(s.material).alphaCutoff;
}

Shading shadingAt(Surface s) {
    Material material = MATERIAL(s.material);
    Shading r;
    r.flags = material.flags;
    vec4 base = material.baseColor;
    if (HAS(EFFECT_VERTEX_COLORS)) base = base * s.color;
    r.roughness = material.roughness;
    float metallic = material.metallic;
    r.transmission = material.transmission;
    r.f0 = vec3(material.specular.x, material.specular.y, material.specular.z);
    r.emission = vec3(material.emission.x, material.emission.y, material.emission.z);
    r.normal = s.normal;
    if (HAS(EFFECT_TEXTURES)) {
        if (material.baseTexture != NO_INDEX) base = base * sampleTexture(material.baseTexture, s.uv0, s.uv1, s.footprint);
        if (material.opacityTexture != NO_INDEX) {
            vec4 texel = sampleTexture(material.opacityTexture, s.uv0, s.uv1, s.footprint);
            base.w = base.w * ((material.flags & MATERIAL_OPACITY_RED) != 0u ? texel.x : texel.w);
        }
        if (material.metallicRoughnessTexture != NO_INDEX) {
            vec4 texel = sampleTexture(material.metallicRoughnessTexture, s.uv0, s.uv1, s.footprint);
            r.roughness = r.roughness * texel.y;
            metallic = metallic * texel.z;
        }
        if (material.transmissionTexture != NO_INDEX)
            r.transmission = r.transmission * sampleTexture(material.transmissionTexture, s.uv0, s.uv1, s.footprint).x;
        if (material.specularTexture != NO_INDEX) {
            vec4 texel = sampleTexture(material.specularTexture, s.uv0, s.uv1, s.footprint);
            r.f0 = r.f0 * vec3(texel.x, texel.y, texel.z);
        }
        if (material.emissionTexture != NO_INDEX) {
            vec4 texel = sampleTexture(material.emissionTexture, s.uv0, s.uv1, s.footprint);
            r.emission = r.emission * vec3(texel.x, texel.y, texel.z);
        }
        if (HAS(EFFECT_NORMAL_MAPS) && material.normalTexture != NO_INDEX) r.normal = mappedNormal(s, material);
    }
    r.ior = material.ior;
    r.exponent = material.specular.w;
    r.mirror = material.mirror;
    bool blend = (material.flags & MATERIAL_ALPHA_BLEND) != 0u;
    r.alpha = blend ? saturate(base.w) : 1.0f;
    vec3 color = vec3(base.x, base.y, base.z);
    r.tint = vec3(material.transmissionTint.x, material.transmissionTint.y, material.transmissionTint.z);
    if ((material.flags & MATERIAL_PHONG) != 0u) {
        r.diffuse = color * ((1.0f - r.transmission) * (1.0f - r.mirror));
    } else {
        // glTF 2.0, appendix B: dielectrics reflect ((ior - 1) / (ior + 1))^2, metals their base colour. ior 0 stands for
        // a surface that reflects everything (KHR_materials_ior).
        float k = (r.ior - 1.0f) / (r.ior + 1.0f);
        float dielectric = r.ior > 0.0f ? k * k : 1.0f;
        r.f0 = r.f0 * (dielectric * (1.0f - metallic)) + color * metallic;
        r.tint = r.tint * color;
        r.transmission = r.transmission * (1.0f - metallic);
        r.diffuse = color * ((1.0f - metallic) * (1.0f - r.transmission));
    }
    if ((material.flags & MATERIAL_UNLIT) != 0u) {
        r.emission = r.emission + color;
        r.diffuse = vec3(0.0f, 0.0f, 0.0f);
        r.f0 = r.diffuse;
        r.transmission = 0.0f;
        r.mirror = 0.0f;
        r.exponent = 0.0f;
    }
    return r;
}

// Reflected radiance per unit irradiance for light from wi seen from wo (unit vectors), cosine included. Phong: the
// classical lobe, its peak 1 at any exponent, over pi so that Kd and Ks weigh alike.
vec3 reflectedLight(Shading m, vec3 wo, vec3 wi) {
    float nDotL = dot(m.normal, wi);
    if (!(nDotL > 0.0f)) return vec3(0.0f, 0.0f, 0.0f);
    if ((m.flags & MATERIAL_PHONG) != 0u) {
        vec3 result = m.diffuse * (nDotL * INV_PI);
        if (m.exponent > 1.0f) {
            vec3 r = m.normal * (2.0f * nDotL) - wi;
            result = result + m.f0 * (powKernel(saturate(dot(r, wo)), m.exponent) * INV_PI);
        }
        return result;
    }
    vec3 h = normalize3(wo + wi);
    float nDotV = max(dot(m.normal, wo), 1.0e-4f);
    float nDotH = saturate(dot(m.normal, h));
    vec3 f = fresnelSchlick(m.f0, saturate(dot(wo, h)));
    float a = max(m.roughness * m.roughness, 2.0e-3f);
    float lobe = distributionGgx(nDotH, a) * visibilityGgx(nDotV, nDotL, a);
    vec3 kept = vec3(1.0f, 1.0f, 1.0f) - f;
    return (m.diffuse * kept * INV_PI + f * lobe) * nDotL;
}

// How much of the specular reflection is followed by a ray; the rest is rough and taken from the ambient light.
float traceableShare(float roughness) {
    float x = saturate((0.4f - roughness) * 5.0f);  // 1 up to 0.2, 0 from 0.4
    return x * x * (3.0f - 2.0f * x);
}

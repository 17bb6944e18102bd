// Iridescence: a film so thin that light which it reflects at its two sides interferes, as on soap or tempered steel
// (KHR_materials_iridescence). Belcour & Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence"
// (2017): two orders of interference, the eye's sensitivities as sums of Gaussians. Seen under the normal's angle for all facets.

float fresnel0Between(float a, float b) { return square((a - b) / (a + b)); }

float schlickFrom(float f0, float cosine) {
    float m = saturate(1.0f - cosine);
    return f0 + (1.0f - f0) * (m * m * m * m * m);
}

float cosineOf(float radians) {
    float turn = radians * (0.5f * INV_PI);
    float sine;
    float cosine;
    sinCosTurn(turn - floor(turn), sine, cosine);
    return cosine;
}

float gaussianWave(float value, float position, float variance, float phase, float shift) {
    return value * sqrt(2.0f * PI * variance) * cosineOf(position * phase + shift) * expKernel(-phase * phase * variance);
}

// What the eye sees of light whose paths differ by `path` metres, in linear sRGB; `shift`: phases of the three channels.
vec3 filmSensitivity(float path, vec3 shift) {
    float phase = 2.0f * PI * path;
    float x = gaussianWave(5.4856e-13f, 1.6810e6f, 4.3278e9f, phase, shift.x);
    x = x + gaussianWave(9.7470e-14f, 2.2399e6f, 4.5282e9f, phase, shift.x);
    float y = gaussianWave(4.4201e-13f, 1.7953e6f, 9.3046e9f, phase, shift.y);
    float z = gaussianWave(5.2481e-13f, 2.2084e6f, 6.6121e9f, phase, shift.z);
    float scale = 9358914.0f;  // 1 / 1.0685e-7
    return vec3(3.2404542f * x - 1.5371385f * y - 0.4985314f * z, -0.9692660f * x + 1.8760108f * y + 0.0415560f * z,
                0.0556434f * x - 0.2040259f * y + 1.0572252f * z) * scale;
}

float filmChannel(float r12, float rest, float r23) { return rest * rest * r23 / (1.0f - min(r12 * r23, 0.9999f)); }

// Reflectance of a film of that index and `nanometres` over a body that reflects f0, from air.
vec3 filmReflectance(float index, float nanometres, float cosine, vec3 f0) {
    float fade = saturate(nanometres / 0.03f);
    float ior = 1.0f + (index - 1.0f) * (fade * fade * (3.0f - 2.0f * fade));
    float radicand = 1.0f - (1.0f - cosine * cosine) / (ior * ior);
    bool total = radicand < 0.0f;
    float inside = sqrt(max(radicand, 0.0f));
    float r12 = schlickFrom(fresnel0Between(ior, 1.0f), cosine);
    float rest = 1.0f - r12;
    float phase21 = SELECT(ior < 1.0f, 0.0f, PI);
    vec3 root = vec3(sqrt(min(max(f0.x, 0.0f), 0.9999f)), sqrt(min(max(f0.y, 0.0f), 0.9999f)), sqrt(min(max(f0.z, 0.0f), 0.9999f)));
    vec3 base = vec3((1.0f + root.x) / (1.0f - root.x), (1.0f + root.y) / (1.0f - root.y), (1.0f + root.z) / (1.0f - root.z));
    vec3 r23 = vec3(schlickFrom(fresnel0Between(base.x, ior), inside), schlickFrom(fresnel0Between(base.y, ior), inside),
                    schlickFrom(fresnel0Between(base.z, ior), inside));
    vec3 shift = vec3(phase21 + SELECT(base.x < ior, PI, 0.0f), phase21 + SELECT(base.y < ior, PI, 0.0f),
                      phase21 + SELECT(base.z < ior, PI, 0.0f));
    float path = 2.0f * ior * nanometres * inside * 1.0e-9f;
    vec3 rs = vec3(filmChannel(r12, rest, r23.x), filmChannel(r12, rest, r23.y), filmChannel(r12, rest, r23.z));
    vec3 both = vec3(sqrt(min(max(r12 * r23.x, 1.0e-5f), 0.9999f)), sqrt(min(max(r12 * r23.y, 1.0e-5f), 0.9999f)),
                     sqrt(min(max(r12 * r23.z, 1.0e-5f), 0.9999f)));
    vec3 light = rs + vec3(r12, r12, r12);
    vec3 c = (rs - vec3(rest, rest, rest)) * both;
    light = light + c * (filmSensitivity(path, shift) * 2.0f);
    c = c * both;
    light = light + c * (filmSensitivity(2.0f * path, shift * 2.0f) * 2.0f);
    light = vec3(saturate(light.x), saturate(light.y), saturate(light.z));
    return SELECT(total, vec3(1.0f, 1.0f, 1.0f), light);
}

// f0 whose Schlick curve goes through f at that cosine.
float schlickBack(float f, float f90, float cosine) {
    float m = saturate(1.0f - cosine);
    float grazing = min(m * m * m * m * m, 0.9999f);
    return saturate((f - f90 * grazing) / (1.0f - grazing));
}

void addFilm(INOUT(Shading) r, IN(Surface) s, uint layers) {
    r.film = layerNumber(layers, LAYER_iridescence, 0.0f) * layerTexel(layers, LAYER_iridescenceTexture, s).x;
    r.filmIor = layerNumber(layers, LAYER_filmIor, 1.3f);
    float thinnest = layerNumber(layers, LAYER_filmThinnest, 100.0f);
    float thickest = layerNumber(layers, LAYER_filmThickest, 400.0f);
    r.filmThickness = thinnest + (thickest - thinnest) * layerTexel(layers, LAYER_filmThicknessTexture, s).y;
}

// Reflectance straight on, so that what is seen under the angle of wo is the film's.
void seenThroughFilm(INOUT(Shading) m, vec3 wo) {
    bool some = m.film > 0.0f && m.filmThickness > 0.0f;
    if (ANY(some)) {
        float cosine = min(max(dot(m.normal, wo), 1.0e-4f), 1.0f);
        vec3 f = filmReflectance(m.filmIor, m.filmThickness, cosine, m.f0);
        vec3 f0 = vec3(schlickBack(f.x, m.f90, cosine), schlickBack(f.y, m.f90, cosine), schlickBack(f.z, m.f90, cosine));
        m.f0 = SELECT(some, m.f0 + (f0 - m.f0) * m.film, m.f0);
    }
}

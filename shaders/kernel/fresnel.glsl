// Reflection at interfaces.

// Unpolarised reflectance of a dielectric. cosI: cosine of the incident angle, >= 0; eta: index of the side the light
// comes from over that of the other. Returns 1 under total internal reflection and sets cosT, the cosine of the refracted
// angle (0 then). The radicand 1 - eta^2 + eta^2 cos^2 is nearly 0 about the critical angle: its products are taken with their rests.
float fresnelDielectric(float cosI, float eta, OUT(float) cosT) {
    float c = min(cosI, 1.0f);
    float bent = eta * c;
    float small = restOfProduct(bent, bent) - restOfProduct(eta, eta) + 2.0f * bent * restOfProduct(eta, c);
    float radicand = ((1.0f - eta * eta) + bent * bent) + small;
    bool total = radicand < 0.0f;
    cosT = sqrt(max(radicand, 0.0f));
    float parallel = (c - eta * cosT) / max(c + eta * cosT, 1.0e-20f);
    float perpendicular = (eta * c - cosT) / max(eta * c + cosT, 1.0e-20f);
    return SELECT(total, 1.0f, 0.5f * (parallel * parallel + perpendicular * perpendicular));
}

// Reflectance at grazing incidence: all, from f0 = 0.02 (water) upwards; 0 for what does not reflect at all (ior 1). After
// Lagarde & de Rousiers, "Moving Frostbite to Physically Based Rendering" (2014).
float grazingReflectance(vec3 f0) { return min(50.0f * maxComponent(f0), 1.0f); }

// Schlick, "An Inexpensive BRDF Model for Physically-based Rendering" (1994). f0, f90: reflectance straight on and grazing.
vec3 fresnelSchlick(vec3 f0, float f90, float cosine) {
    float m = saturate(1.0f - cosine);
    float m2 = m * m;
    float m5 = m2 * m2 * m;
    return f0 + (vec3(f90, f90, f90) - f0) * m5;
}

// Ground that shows nothing but the shadows on it: where a path meets nothing, a plane under the scene takes from what is behind it
// the share of the light there that the scene keeps away. After differential rendering: Debevec, "Rendering Synthetic Objects
// into Real Scenes" (SIGGRAPH 1998), section 5. What nothing is kept from stays as it was, bit for bit and without noise: rays
// from the ground carry contributions below 0, which count where something is in the way.

FLOAT_CONSTANT(GROUND_REACH, 16.0f)  // radii of the scene about its middle
FLOAT_CONSTANT(GROUND_RIM, 4.0f)     // radii over which it fades

vec3 groundPoint(IN(PathState) p) {
    bool down = p.direction.y < 0.0f;
    float t = (FRAME.groundHeight - p.origin.y) / SELECT(down, p.direction.y, -1.0f);
    return vec3(p.origin.x + p.direction.x * t, FRAME.groundHeight, p.origin.z + p.direction.z * t);
}

float groundWeight(vec3 at) {
    float x = (at.x - FRAME.fogCenter.x) / FRAME.fogRadius;
    float z = (at.z - FRAME.fogCenter.z) / FRAME.fogRadius;
    return saturate((GROUND_REACH - sqrt(x * x + z * z)) / GROUND_RIM);
}

// Whether a path that met nothing looks at the ground from above: from the camera, or by mirrors and clear glass.
bool meetsGround(IN(PathState) p) {
    bool sharp = p.lobe == FLOAT_MAX && (p.depth & DIFFUSED) == 0u && airOfMiss(p) > 0.0f;
    return sharp && p.direction.y < 0.0f && p.origin.y > FRAME.groundHeight && groundWeight(groundPoint(p)) > 0.0f;
}

Surface groundSurface(vec3 at) {
    Surface s;
    vec3 up = vec3(0.0f, 1.0f, 0.0f);
    s.position = at;
    s.shadowPosition = at;
    s.geometricNormal = up;
    s.normal = up;
    s.distance = 0.0f;
    s.clearance = (maxComponent(abs3(at)) + FRAME.fogRadius) * CLEARANCE_OF_POINTS;
    s.side = 1.0f;
    s.material = 0u;
    return s;
}

// White paint. Either model of a material gives it the same bits, so that a device may lack one that the scene does not use.
Shading groundShading() {
    Shading m;
    vec3 none = vec3(0.0f, 0.0f, 0.0f);
    m.normal = vec3(0.0f, 1.0f, 0.0f);
    m.facet = m.normal;
    m.diffuse = vec3(1.0f, 1.0f, 1.0f);
    m.emission = none;
    m.f0 = none;
    m.f90 = 0.0f;
    m.albedo = none;
    m.gain = none;
    m.tint = none;
    m.roughness = 1.0f;
    m.exponent = 0.0f;
    m.alpha = 1.0f;
    m.transmission = 0.0f;
    m.mirror = 0.0f;
    m.ior = 1.0f;
    m.occlusion = 1.0f;
    m.flags = 0u;
    if (!MET(VARIETY_MICROFACET)) m.flags = MATERIAL_PHONG;
    m.kept = 1.0f;
    m.coat = 0.0f;
    m.sheen = none;
    m.sheenAlbedo = none;
    m.sheenRoughness = 1.0f;
    m.sheenTable = 0u;
    m.widthAlong = 0.0f;
    m.widthAcross = 0.0f;
    m.film = 0.0f;
    m.through = none;
    return m;
}

// What white paint there would send back if nothing were in the way, of all light whose rays can be kept from it. A light with an
// extent counts by its middle.
vec3 lightOnGround(vec3 at) {
    vec3 sum = diffuseAmbient(vec3(0.0f, 1.0f, 0.0f));
    for (UNIFORM_UINT i = 0u; i < FRAME.lightCount; i++) {
        LightSample light = lightAt(i, at);
        sum = sum + light.irradiance * (max(light.direction.y, 0.0f) * INV_PI);
    }
    return sum;
}

float shareOf(float behind, float light) { return SELECT(light > 0.0f, behind / SELECT(light > 0.0f, light, 1.0f), 0.0f); }

// The hit on the ground of a path that meetsGround, whose `radiance` holds what is behind already.
Arrival onGround(IN(PathState) p, INOUT(vec3) radiance) {
    Arrival a;
    vec3 at = groundPoint(p);
    vec3 behind = missRadiance(p) * groundWeight(at);
    vec3 light = lightOnGround(at);
    vec3 taken = vec3(shareOf(behind.x, light.x), shareOf(behind.y, light.y), shareOf(behind.z, light.z));
    a.surface = groundSurface(at);
    a.shading = groundShading();
    a.wo = -p.direction;
    a.throughput = -taken;
    a.ambient = taken * diffuseOfAmbient(a.shading);
    a.occlusion = isWorthOcclusion(a.ambient);
    radiance = SELECT(a.occlusion, radiance - a.ambient, radiance);
    a.air = 0.0f;
    a.media = 0u;
    a.mediaLost = 0u;
    a.next = 0u;
    a.shares.diffuseChance = 0.0f;
    a.shares.specularChance = 0.0f;
    a.shares.specularFromSky = 0.0f;
    a.shares.specularFromGlow = 0.0f;
    a.shares.coatChance = 0.0f;
    a.shares.coatFromSky = 0.0f;
    a.shares.coatFromGlow = 0.0f;
    return a;
}

bool isTaken(vec3 contribution) { return min(contribution.x, min(contribution.y, contribution.z)) < 0.0f; }

// Whether something has to find out how much of a contribution arrives.
bool isWorthRay(vec3 contribution) {
    bool some = maxComponent(contribution) > 0.0f;
    if (HAS_LAYER(EFFECT_GROUND)) some = some || isTaken(contribution);
    return some;
}

// What a ray to a light adds when `share` of its light gets through.
vec3 lightArriving(vec3 contribution, vec3 share) {
    vec3 result = contribution * share;
    if (HAS_LAYER(EFFECT_GROUND)) result = SELECT(isTaken(contribution), contribution * (vec3(1.0f, 1.0f, 1.0f) - share), result);
    return result;
}

// Glowing surfaces are not part of lightOnGround.
vec3 withoutLamps(vec3 contribution) {
    if (HAS_LAYER(EFFECT_GROUND)) return SELECT(isTaken(contribution), vec3(0.0f, 0.0f, 0.0f), contribution);
    return contribution;
}

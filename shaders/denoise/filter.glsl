// The edge-avoiding filter, as what one pixel does with one neighbour; drivers walk over the picture (server/denoise on
// processors, denoise/denoise.comp on GPUs). An a-trous wavelet of light without the surfaces' colour, in rounds whose neighbours
// lie twice as far apart each time: Dammertz et al., "Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination
// Filtering" (2010). Where it stops is told by normal, distance and the noise of the light, with the variance filtered along:
// Schied et al., "Spatiotemporal Variance-Guided Filtering" (2017), without its history.

FLOAT_CONSTANT(LEAST_ALBEDO, 0.01f)
FLOAT_CONSTANT(NORMAL_CUT, 8.0f)  // neighbours whose normals differ by more than acos(1 - 1/8), 29 degrees, count nothing
FLOAT_CONSTANT(PLANE_CUT, 50.0f)  // nor those off the pixel's plane by a fiftieth of the distance
FLOAT_CONSTANT(NOISE_CUT, 8.0f)   // differences of light count as noise up to sqrt(8) standard deviations of both, from sqrt(16) on not
UINT_CONSTANT(DENOISE_ROUNDS, 5u)

// ---- what guides.glsl packs ----

vec3 unpackedNormal(uint word) {
    float x = float(int(word & 2047u)) * (2.0f / 2047.0f) - 1.0f;
    float y = float(int((word >> 11) & 2047u)) * (2.0f / 2047.0f) - 1.0f;
    float z = 1.0f - abs(x) - abs(y);
    float over = max(-z, 0.0f);
    return normalize3(vec3(x + SELECT(x < 0.0f, over, -over), y + SELECT(y < 0.0f, over, -over), z));
}

vec3 unpackedAlbedo(uint word) {
    float r = float(int(word & 255u)) * (1.0f / 255.0f);
    float g = float(int((word >> 8) & 255u)) * (1.0f / 255.0f);
    float b = float(int((word >> 16) & 255u)) * (1.0f / 255.0f);
    return vec3(r * r, g * g, b * b);
}

float sharpShare(uint word) { return float(int((word >> 22) & 3u)) * (1.0f / 3.0f); }

// ---- what looks alike ----

// What is known of a pixel's surface. Where there is none the normal is (2, 0, 0), which is like itself alone, and the nearness 0;
// outside the picture the nearness is -1, which is like none.
struct GuidePixel {
    vec3 normal;
    float nearness;  // one over the distance along the camera's axis
};

GuidePixel guidePixel(uint normalWord, float nearness) {
    GuidePixel g;
    vec3 normal = unpackedNormal(normalWord);
    g.normal = SELECT(nearness > 0.0f, normal, vec3(2.0f, 0.0f, 0.0f));
    g.nearness = nearness;
    return g;
}

// What nearness grows by from one pixel to the next on the pixel's own surface: the smaller one of both sides, of those that lie in
// the picture.
float nearnessSlope(float before, float own, float after) {
    float down = SELECT(before < 0.0f, 1.0e30f, own - before);
    float up = SELECT(after < 0.0f, 1.0e30f, after - own);
    float slope = SELECT(abs(down) < abs(up), down, up);
    return SELECT(own > 0.0f && slope < 1.0e30f, slope, 0.0f);
}

// How much a neighbour looks like a place on the pixel's own surface, 0 to 1. `expected`: its nearness if it is one. `cut`:
// PLANE_CUT over the pixel's nearness.
float surfaceLikeness(IN(GuidePixel) own, IN(GuidePixel) other, float expected, float cut) {
    float turn = saturate(1.0f - NORMAL_CUT * (1.0f - dot(own.normal, other.normal)));
    float off = saturate(1.0f - abs(other.nearness - expected) * cut);
    return SELECT(other.nearness < 0.0f, 0.0f, turn * turn * off);
}

float planeCut(float nearness) { return PLANE_CUT / max(nearness, 1.0e-20f); }

// How much of the difference of two lights noise explains. By the noise of both, so that each counts for the other what the other
// counts for it: the few bright samples of a dark place are given to the neighbours, not taken from them.
float lightLikeness(float own, float other, float variances) {
    float apart = own - other;
    return saturate(2.0f - apart * apart / (NOISE_CUT * variances + 1.0e-12f * own * own + 1.0e-18f));
}

vec3 divisorOf(uint albedoWord) {
    vec3 albedo = unpackedAlbedo(albedoWord);
    return vec3(max(albedo.x, LEAST_ALBEDO), max(albedo.y, LEAST_ALBEDO), max(albedo.z, LEAST_ALBEDO));
}

// ---- light ----

// Light without the surface's colour, and the variance of its luminance; below 0 stays so.
float demodulated(float light, float divisor) { return min(light / divisor, 1.0e18f); }
float demodulatedVariance(float variance, vec3 divisor) {
    float scale = 1.0f / luminance(divisor);
    return SELECT(variance < 0.0f, variance, min(variance * (scale * scale), 1.0e36f));
}

// What like neighbours show of a pixel's noise: the pixel, and those one and two pixels off.
struct Around {
    float weights;
    float lights;
    float squares;
    float variances;
};

Around aroundNothing() {
    Around a;
    a.weights = 0.0f;
    a.lights = 0.0f;
    a.squares = 0.0f;
    a.variances = 0.0f;
    return a;
}

void addAround(INOUT(Around) a, float like, float light, float variance) {
    a.weights = a.weights + like;
    a.lights = a.lights + like * light;
    a.squares = a.squares + like * (light * light);
    a.variances = a.variances + like * variance;
}

// By the samples' own variances where all have them, else by how far one-sample lights differ. What varies in mirrors and glass are
// the edges of what they show: those pixels are taken for what they are.
float varianceAround(IN(Around) a, float sharp) {
    float scale = 1.0f / max(a.weights, 1.0e-6f);
    float mean = a.lights * scale;
    float left = 1.0f - sharp;
    float apart = max(a.squares * scale - mean * mean, 0.0f);
    return SELECT(a.variances < 0.0f, apart, a.variances * scale) * (left * left);
}

// Sums over neighbours.
struct Gathered {
    vec3 light;
    float weights;
    float variance;
};

// (1 2 1) in either direction, over 16.
FLOAT_CONSTANT(OWN_WEIGHT, 0.25f)
FLOAT_CONSTANT(SIDE_WEIGHT, 0.125f)
FLOAT_CONSTANT(CORNER_WEIGHT, 0.0625f)

Gathered gatheredOwn(vec3 light, float variance) {
    Gathered g;
    g.light = light * OWN_WEIGHT;
    g.weights = OWN_WEIGHT;
    g.variance = variance * (OWN_WEIGHT * OWN_WEIGHT);
    return g;
}

void addNeighbour(INOUT(Gathered) g, float weight, vec3 light, float variance) {
    g.light = g.light + light * weight;
    g.weights = g.weights + weight;
    g.variance = g.variance + variance * (weight * weight);
}

vec3 gatheredLight(IN(Gathered) g) { return g.light * (1.0f / g.weights); }
float gatheredVariance(IN(Gathered) g) {
    float scale = 1.0f / g.weights;
    return g.variance * (scale * scale);
}

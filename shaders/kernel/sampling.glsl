// Sample values from (pixel, sample, dimension) alone. Camera jitter follows the R2 sequence (Roberts, "The Unreasonable
// Effectiveness of Quasirandom Sequences", 2018), which starts at the pixel's centre; hemisphere samples come from an
// Owen-scrambled Sobol table (host: render/kernel_tables), shifted digit-wise per pixel and path vertex.

UINT_CONSTANT(SOBOL_COUNT, 4096u)  // points in the table, a power of two

// Mixes bits: every input bit changes about half of the output bits. Constants: Ettinger's "lowbias32" search (2018).
uint hashUint(uint value) {
    uint x = value;
    x = x ^ (x >> 16);
    x = x * 0x7feb352du;
    x = x ^ (x >> 15);
    x = x * 0x846ca68bu;
    x = x ^ (x >> 16);
    return x;
}

uint hashPixel(uvec2 pixel, uint salt) {
    return hashUint(pixel.x + hashUint(pixel.y + hashUint(salt)));
}

// [0, 1): 24 bits, so that 1 is never reached.
float unitFloat(uint bits) { return float(int(bits >> 8)) * 5.9604644775390625e-8f; }

// Offset inside the pixel in [0, 1)^2 of sample `index`; index 0 is the centre.
vec2 pixelJitter(UNIFORM_UINT index) {
    return vec2(unitFloat(0x80000000u + index * 0xc13fa9a9u), unitFloat(0x80000000u + index * 0x91e10da5u));
}

// Cosine-distributed direction about +z from two numbers in [0, 1); pdf = z / pi.
vec3 cosineHemisphere(float u, float v) {
    float r = sqrt(u);
    float s;
    float c;
    sinCosTurn(v, s, c);
    return vec3(r * c, r * s, sqrt(1.0f - u));
}

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

uint reverseBits(uint value) {
    uint x = value;
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

// Point `number` of the Sobol table in an order of its own for each seed, in which the first 2^n numbers still get points that
// are spread evenly. For values that are combined with other values of the same sample: in one order a place on the lens would
// always go with the same place on a lamp. Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4) 2020.
uvec2 shuffledPoint(UNIFORM_UINT number, uint seed) {
    uint x = reverseBits(uint(number));
    x = x ^ (x * 0x3d20adeau);
    x = x + seed;
    x = x * ((seed >> 16) | 1u);
    x = x ^ (x * 0x05526c56u);
    x = x ^ (x * 0x53a22864u);
    return SOBOL_AT(reverseBits(x) & (SOBOL_COUNT - 1u));
}

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

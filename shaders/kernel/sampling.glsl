// Sample values from (pixel, sample, dimension) alone. Camera jitter follows the R2 sequence (Roberts, "The Unreasonable
// Effectiveness of Quasirandom Sequences", 2018), which starts at the pixel's centre; hemisphere samples come from an
// Owen-scrambled Sobol sequence, shifted digit-wise per pixel and path vertex. Its first points stand in a table.

UINT_CONSTANT(SOBOL_COUNT, 4096u)  // points in the table (scene/kernel_tables), a power of two
UINT_CONSTANT(SOBOL_SEED_X, 0x8f2b3c51u)
UINT_CONSTANT(SOBOL_SEED_Y, 0x1d9a7e63u)

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

// Each bit changes by the ones below it. Laine & Karras, "Stratified Sampling for Stochastic Transparency" (2011); constants by
// Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4) 2020.
uint hashUpwards(uint value, uint seed) {
    uint x = value;
    x = x ^ (x * 0x3d20adeau);
    x = x + seed;
    x = x * ((seed >> 16) | 1u);
    x = x ^ (x * 0x05526c56u);
    return x ^ (x * 0x53a22864u);
}

// Point `index` of the sequence beyond its table: 32-bit fixed point in [0, 1). The first coordinate of Sobol's (0,2)-sequence is
// the index with its bits reversed. The second multiplies the index by Pascal's triangle modulo 2, which is a power of a 2 x 2
// matrix, and so takes five steps. Ahmed, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact" (2024).
uvec2 sobolBeyond(uint index) {
    uint y = index;
    y = y ^ ((y >> 1) & 0x55555555u);
    y = y ^ ((y >> 2) & 0x33333333u);
    y = y ^ ((y >> 4) & 0x0f0f0f0fu);
    y = y ^ ((y >> 8) & 0x00ff00ffu);
    y = y ^ (y >> 16);
    return uvec2(reverseBits(hashUpwards(index, SOBOL_SEED_X)), reverseBits(hashUpwards(y, SOBOL_SEED_Y)));
}

// Point `number` of the sequence.
uvec2 sobolPoint(UNIFORM_UINT number) {
    if (number < SOBOL_COUNT) return SOBOL(number);
    return sobolBeyond(uint(number));
}

// Point `number` of the sequence in an order of its own for each seed, in which the first 2^n numbers still get points that are
// spread evenly. For values that are combined with other values of the same sample: in one order a place on the lens would always
// go with the same place on a lamp. The order is that of 4096 points, in each 4096 of them.
uvec2 shuffledPoint(UNIFORM_UINT number, uint seed) {
    uint index = reverseBits(hashUpwards(reverseBits(uint(number)), seed)) & (SOBOL_COUNT - 1u);
    if (number < SOBOL_COUNT) return SOBOL_AT(index);
    return sobolBeyond(index | uint(number & ~(SOBOL_COUNT - 1u)));
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

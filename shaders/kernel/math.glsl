// Arithmetic that gives the same bits on every device: + - * / sqrt floor alone are exact everywhere, so every
// transcendental function of the kernel is built of them here. Errors are stated against exact values.
// Polynomials: Abramowitz & Stegun, Handbook of Mathematical Functions (1964), 4.4.46 and 4.4.49; Cody & Waite reductions.

FLOAT_CONSTANT(PI, 3.14159265358979f)
FLOAT_CONSTANT(INV_PI, 0.318309886183791f)
FLOAT_CONSTANT(FLOAT_MAX, 3.402823466e38f)

float square(float x) { return x * x; }

float saturate(float x) { return min(max(x, 0.0f), 1.0f); }

float maxComponent(vec3 v) { return max(max(v.x, v.y), v.z); }

float luminance(vec3 c) { return LUMINANCE_RED * c.x + LUMINANCE_GREEN * c.y + LUMINANCE_BLUE * c.z; }

// What the rounded product of a and b lacks, exactly. Dekker, "A Floating-Point Technique for Extending the Available Precision" (1971).
float restOfProduct(float a, float b) {
    float wideA = 4097.0f * a;
    float wideB = 4097.0f * b;
    float highA = wideA - (wideA - a);
    float highB = wideB - (wideB - b);
    float lowA = a - highA;
    float lowB = b - highB;
    return lowA * lowB - ((a * b - highA * highB) - lowA * highB - highA * lowB);
}

// Unit vector; (0, 0, 0) stays what it is.
vec3 normalize3(vec3 v) {
    float lengthSquared = dot(v, v);
    float scale = 1.0f / sqrt(SELECT(lengthSquared > 0.0f, lengthSquared, 1.0f));
    return v * scale;
}

bool isFinite3(vec3 v) {
    return abs(v.x) <= FLOAT_MAX && abs(v.y) <= FLOAT_MAX && abs(v.z) <= FLOAT_MAX;
}

// 2^n for integer n in [-126, 127].
float exp2Integer(int n) { return intBitsToFloat((n + 127) << 23); }

// e^x for x in [-87, 88], clamped outside; relative error < 3e-7.
float expKernel(float x) {
    float clamped = min(max(x, -87.0f), 88.0f);
    float n = floor(clamped * 1.44269504f + 0.5f);
    float r = (clamped - n * 0.693359375f) + n * 2.12194440e-4f;
    float p = 1.9875691500e-4f;
    p = p * r + 1.3981999507e-3f;
    p = p * r + 8.3334519073e-3f;
    p = p * r + 4.1665795894e-2f;
    p = p * r + 1.6666665459e-1f;
    p = p * r + 5.0000001201e-1f;
    float e = (p * r) * r + r + 1.0f;
    return e * exp2Integer(int(n));
}

// Natural logarithm of x > 0 (normal floats); absolute error < 2e-7 near 1, relative < 2e-7 elsewhere.
float logKernel(float x) {
    int bits = floatBitsToInt(x);
    int exponent = ((bits - 0x3f3504f3) >> 23);  // mantissa in [sqrt(1/2), sqrt(2))
    float m = intBitsToFloat(bits - (exponent << 23));
    float s = (m - 1.0f) / (m + 1.0f);
    float s2 = s * s;
    float p = 0.111111111f;
    p = p * s2 + 0.142857143f;
    p = p * s2 + 0.2f;
    p = p * s2 + 0.333333333f;
    float logM = 2.0f * s + 2.0f * s * s2 * p;
    return float(exponent) * 0.693147181f + logM;
}

// log2 with an absolute error < 0.01, for choosing mip levels; x > 0.
float log2Rough(float x) {
    int bits = floatBitsToInt(x);
    float exponent = float((bits >> 23) - 127);
    float m = intBitsToFloat((bits & 0x007fffff) | 0x3f800000);
    return exponent + (m - 1.0f) * (1.3465553f - 0.3465553f * (m - 1.0f));
}

// x^y for x >= 0; 0^0 = 1.
float powKernel(float x, float y) {
    float power = expKernel(y * logKernel(max(x, 1.0e-30f)));
    return SELECT(y == 0.0f, 1.0f, SELECT(x <= 1.0e-30f, 0.0f, power));
}

// Sine and cosine of a full turn times `turn`, turn in [0, 1); absolute error < 2e-7.
void sinCosTurn(float turn, OUT(float) sine, OUT(float) cosine) {
    float quarter = turn * 4.0f;
    float n = floor(quarter + 0.5f);
    float a = (quarter - n) * 1.57079633f;  // in [-pi/4, pi/4]
    float a2 = a * a;
    float s = ((-1.9515295891e-4f * a2 + 8.3321608736e-3f) * a2 - 1.6666654611e-1f) * a2 * a + a;
    float c = ((2.443315711809948e-5f * a2 - 1.388731625493765e-3f) * a2 + 4.166664568298827e-2f) * a2 * a2
              - 0.5f * a2 + 1.0f;
    int q = int(n) & 3;
    float s1 = SELECT((q & 1) != 0, c, s);
    float c1 = SELECT((q & 1) != 0, s, c);
    sine = SELECT((q & 2) != 0, -s1, s1);
    cosine = SELECT(q == 1 || q == 2, -c1, c1);
}

// arccos for x in [-1, 1], clamped outside; absolute error < 5e-7.
float acosKernel(float x) {
    float a = min(abs(x), 1.0f);
    float p = -0.0012624911f;
    p = p * a + 0.0066700901f;
    p = p * a - 0.0170881256f;
    p = p * a + 0.0308918810f;
    p = p * a - 0.0501743046f;
    p = p * a + 0.0889789874f;
    p = p * a - 0.2145988016f;
    p = p * a + 1.5707963050f;
    float r = sqrt(1.0f - a) * p;
    return SELECT(x < 0.0f, PI - r, r);
}

// Angle of (x, y) in (-pi, pi]; (0, 0) gives 0; absolute error < 5e-7.
float atan2Kernel(float y, float x) {
    float ax = abs(x);
    float ay = abs(y);
    float high = max(ax, ay);
    float low = min(ax, ay);
    float t = low / SELECT(high > 0.0f, high, 1.0f);
    float t2 = t * t;
    float p = 0.0028662257f;
    p = p * t2 - 0.0161657367f;
    p = p * t2 + 0.0429096138f;
    p = p * t2 - 0.0752896400f;
    p = p * t2 + 0.1065626393f;
    p = p * t2 - 0.1420889944f;
    p = p * t2 + 0.1999355085f;
    p = p * t2 - 0.3333314528f;
    float angle = p * t2 * t + t;
    angle = SELECT(ay > ax, 1.57079633f - angle, angle);
    angle = SELECT(x < 0.0f, PI - angle, angle);
    return SELECT(y < 0.0f, -angle, angle);
}

// Two vectors that complete the unit vector n to a right-handed basis. Duff et al., "Building an Orthonormal Basis,
// Revisited", JCGT 6(1) 2017.
void orthonormalBasis(vec3 n, OUT(vec3) tangent, OUT(vec3) bitangent) {
    float s = SELECT(n.z >= 0.0f, 1.0f, -1.0f);
    float a = -1.0f / (s + n.z);
    float b = n.x * n.y * a;
    tangent = vec3(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    bitangent = vec3(b, s + n.y * n.y * a, -n.y);
}

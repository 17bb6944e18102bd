// The path integrator: of the rays that the interactive one would send on from a hit, one, chosen by weight. Direct light comes
// from rays to the lights at every hit, and all else from where the path goes. Kajiya, "The Rendering Equation" (1986). Left
// out: light that only passes solid glass to a light without extent.

UINT_CONSTANT(PATH_SALT, 0x70617468u)
FLOAT_CONSTANT(LEAST_CHANCE, 0.05f)  // that a path goes on

float weightOf(uint next, uint bit, IN(PathState) path) {
    return SELECT((next & bit) != 0u, maxComponent(path.throughput), 0.0f);
}

// Ends the path of a.next with the chance that it lacks of full weight, and gives the others what it carried: Arvo & Kirk, "Particle
// Transport and Image Synthesis" (1990). The shares of light with rays to sampled lights stay as they are: they add up to one
// whatever the chance. `v` in [0, 1).
void endByChance(float v, INOUT(Arrival) a) {
#define END_BY_CHANCE(bit, path)                                                                       \
    {                                                                                                  \
        bool taken = (a.next & bit) != 0u && bounces(a.path.depth) >= FRAME.russianRoulette;           \
        float chance = SELECT(taken, min(max(maxComponent(a.path.throughput), LEAST_CHANCE), 1.0f), 1.0f); \
        a.next = SELECT(taken && v >= chance, uint(0u), a.next);                                       \
        a.path.throughput = a.path.throughput * (1.0f / chance);                                       \
    }
    FOR_NEXT_PATHS(END_BY_CHANCE)
}

// Keeps one of the paths that go on, weighted by one over its chance; tells the rays to sampled lights of it.
void chooseOne(uvec2 pixel, UNIFORM_UINT sampleIndex, uint salt, INOUT(Arrival) a) {
    float diffuse = weightOf(a.next, NEXT_INDIRECT, a.indirect);
    // By several lobes the mean, as by facets.
    if (HAS_LAYER(EFFECT_SHEEN | EFFECT_DIFFUSE_TRANSMISSION))
        diffuse = SELECT((a.next & NEXT_INDIRECT) != 0u, maxComponent(diffuseShare(a.shading, a.throughput)), 0.0f);
    float reflected = weightOf(a.next, NEXT_REFLECTION, a.reflection);
    // By facets a mean of theirs: the chance of each way has to be the same for rays to lights, which know nothing of the facet.
    bool shared_ = a.shares.specularChance > 0.0f;
    reflected = SELECT(shared_, reflectedShare(a.shading, a.throughput, vec3(0.0f, 0.0f, 0.0f)), reflected);
    float passed = weightOf(a.next, NEXT_PASS, a.pass);
    float refracted = weightOf(a.next, NEXT_REFRACTION, a.refraction);
    float coated = 0.0f;
    if (HAS_LAYER(EFFECT_CLEARCOAT)) {
        coated = weightOf(a.next, NEXT_COAT, a.coat);
        coated = SELECT(a.shares.coatChance > 0.0f, maxComponent(a.throughput) * a.shading.coatAlbedo * a.shading.alpha, coated);
    }
    float sum = diffuse + reflected + passed + refracted + coated;
    float perSum = 1.0f / SELECT(sum > 0.0f, sum, 1.0f);
    uint shift = hashPixel(pixel, hashUint(salt + PATH_SALT) + FRAME.seed);
    uvec2 number = shuffledPoint(sampleIndex, shift);
    float u = unitFloat(number.x ^ shift) * sum;
    uint next = SELECT(u < diffuse, uint(NEXT_INDIRECT), SELECT(u < diffuse + reflected, uint(NEXT_REFLECTION),
                SELECT(u < diffuse + reflected + passed, uint(NEXT_PASS), uint(NEXT_REFRACTION))));
    if (HAS_LAYER(EFFECT_CLEARCOAT)) {
        next = SELECT(u >= sum - coated && coated > 0.0f, uint(NEXT_COAT), next);
        a.coat.throughput = a.coat.throughput * (sum / max(coated, 1.0e-30f));
        float facets = a.coat.lobe * (coated * perSum);
        a.coat.lobe = SELECT(a.coat.lobe < FLOAT_MAX, facets, FLOAT_MAX);
        a.shares.coatChance = a.shares.coatChance * (coated * perSum);
    }
    a.next = a.next & next;
    a.indirect.throughput = a.indirect.throughput * (sum / max(diffuse, 1.0e-30f));
    a.indirect.lobe = a.indirect.lobe * (diffuse * perSum);
    a.reflection.throughput = a.reflection.throughput * (sum / max(reflected, 1.0e-30f));
    float lobe = a.reflection.lobe * (reflected * perSum);
    a.reflection.lobe = SELECT(a.reflection.lobe < FLOAT_MAX, lobe, FLOAT_MAX);
    a.pass.throughput = a.pass.throughput * (sum / max(passed, 1.0e-30f));
    a.refraction.throughput = a.refraction.throughput * (sum / max(refracted, 1.0e-30f));
    a.shares.diffuseChance = a.shares.diffuseChance * (diffuse * perSum);
    a.shares.specularChance = a.shares.specularChance * (reflected * perSum);
    if (FRAME.russianRoulette > 0u) endByChance(unitFloat(number.y ^ hashUint(shift)), a);
}

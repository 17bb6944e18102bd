// Nested media: which bodies a path is in, so that water in a glass meets the glass and not air. Where bodies overlap the one of
// highest priority fills the place: a surface at which that one stays the same is a seam, and a path goes on through it as if
// there were nothing. After Schmidt & Budge, "Simple Nested Dielectrics in Ray Traced Images", Journal of Graphics Tools 7(2) 2002.
//
// PathState.medium holds the set of bodies: four numbers of media, the highest priority lowest, 0 for none. SceneBuilder numbers
// them by priority (Material.medium) and sees that walls that lie on each other overlap (server/scene/build/nested_media.h).

UINT_CONSTANT(MEDIUM_MASK, 127u)
UINT_CONSTANT(MEDIA_MASK, 0x0fffffffu)
UINT_CONSTANT(ONE_SEAM, 0x10000000u)    // in the same word: seams in a row
UINT_CONSTANT(MOST_SEAMS, 15u)
UINT_CONSTANT(MEDIA_UNDERFLOW, 1u)      // a body is left that was never entered
UINT_CONSTANT(MEDIA_OVERFLOW, 2u)       // more than four bodies, or MOST_SEAMS: the lowest one, or the path, is given up

// What a path through a surface changes.
struct Crossing {
    uint before;  // bodies in which the path arrives
    uint after;   // bodies beyond the surface
    uint lost;    // MEDIA_* bits
    bool seam;    // nothing is seen of the surface
};

uint highestMedium(uint media) { return media & MEDIUM_MASK; }
uint mediumOfRank(uint media, UNIFORM_UINT rank) {
    if (rank == 1u) return (media >> 7) & MEDIUM_MASK;
    if (rank == 2u) return (media >> 14) & MEDIUM_MASK;
    if (rank == 3u) return (media >> 21) & MEDIUM_MASK;
    return media & MEDIUM_MASK;
}

bool isAmong(uint medium, uint media) {
    return medium == mediumOfRank(media, 0u) || medium == mediumOfRank(media, 1u) || medium == mediumOfRank(media, 2u)
           || medium == mediumOfRank(media, 3u);
}

// The set with one body more; of five the lowest falls out.
uint withMedium(uint media, uint medium) {
    uint a = mediumOfRank(media, 0u);
    uint b = mediumOfRank(media, 1u);
    uint c = mediumOfRank(media, 2u);
    uint d = mediumOfRank(media, 3u);
    uint first = SELECT(medium > a, medium, a);
    uint second = SELECT(medium > a, a, SELECT(medium > b, medium, b));
    uint third = SELECT(medium > b, b, SELECT(medium > c, medium, c));
    uint fourth = SELECT(medium > c, c, SELECT(medium > d, medium, d));
    return first | (second << 7) | (third << 14) | (fourth << 21);
}

// The set with one body of that medium less, if there is one.
uint withoutMedium(uint media, uint medium) {
    uint a = mediumOfRank(media, 0u);
    uint b = mediumOfRank(media, 1u);
    uint c = mediumOfRank(media, 2u);
    uint d = mediumOfRank(media, 3u);
    bool upToA = medium == a;
    bool upToB = upToA || medium == b;
    bool upToC = upToB || medium == c;
    bool upToD = upToC || medium == d;
    uint first = SELECT(upToA, b, a);
    uint second = SELECT(upToB, c, b);
    uint third = SELECT(upToC, d, c);
    uint fourth = SELECT(upToD, uint(0u), d);
    return first | (second << 7) | (third << 14) | (fourth << 21);
}

// `media`: as PathState.medium has it.
Crossing crossingAt(uint media, IN(Surface) s) {
    Crossing c;
    uint medium = MATERIAL(s.material, medium);
    uint held = media & MEDIA_MASK;
    bool body = medium != 0u;
    bool enters = body && s.side > 0.0f;
    bool leaves = body && !(s.side > 0.0f);
    bool unknown = leaves && !isAmong(medium, held);
    c.before = SELECT(unknown, withMedium(held, medium), held);
    c.after = SELECT(enters, withMedium(held, medium), SELECT(leaves, withoutMedium(c.before, medium), held));
    c.seam = body && highestMedium(c.before) == highestMedium(c.after);
    bool full = (enters || unknown) && mediumOfRank(held, 3u) != 0u;
    bool endless = c.seam && (media >> 28) == MOST_SEAMS;
    c.lost = SELECT(unknown, uint(MEDIA_UNDERFLOW), uint(0u)) | SELECT(full || endless, uint(MEDIA_OVERFLOW), uint(0u));
    return c;
}

// Material that stands for the medium of highest priority; 0 in air.
uint materialOfMedia(uint media) {
    uint medium = highestMedium(media);
    return MATERIAL(SELECT(medium != 0u, medium - 1u, uint(0u)), mediumMaterial);
}

float iorOfMedia(uint media) { return SELECT(highestMedium(media) != 0u, MATERIAL(materialOfMedia(media), ior), 1.0f); }

// Index on the inner side of the surface over that on its outer side: in the place of the material's own, which is against air.
float relativeIor(IN(Crossing) c, IN(Surface) s) {
    bool outside = s.side > 0.0f;
    float inner = iorOfMedia(SELECT(outside, c.after, c.before));
    float outer = iorOfMedia(SELECT(outside, c.before, c.after));
    float relative = SELECT(c.seam, 1.0f, inner * (1.0f / max(outer, 1.0e-3f)));
    return SELECT(MATERIAL(s.material, medium) != 0u, relative, MATERIAL(s.material, ior));
}

// shadingAt for a path in those media.
Shading shadingAmong(uint media, IN(Surface) s) {
    Crossing c = crossingAt(media, s);
    Shading m = shadingWith(s, relativeIor(c, s));
    if (ANY(c.seam)) {
        vec3 black = vec3(0.0f, 0.0f, 0.0f);
        m.diffuse = SELECT(c.seam, black, m.diffuse);
        m.emission = SELECT(c.seam, black, m.emission);
        m.f0 = SELECT(c.seam, black, m.f0);
        m.f90 = SELECT(c.seam, 0.0f, m.f90);
        m.tint = SELECT(c.seam, vec3(1.0f, 1.0f, 1.0f), m.tint);
        m.roughness = SELECT(c.seam, 0.0f, m.roughness);
        m.exponent = SELECT(c.seam, 0.0f, m.exponent);
        m.alpha = SELECT(c.seam, 1.0f, m.alpha);
        m.transmission = SELECT(c.seam, 1.0f, m.transmission);
        m.mirror = SELECT(c.seam, 0.0f, m.mirror);
    }
    return m;
}

// Indirect light: the diffuse part of a surface looks along one ray a sample, spread by the cosine, instead of taking the
// ambient light. What the ray meets is lit by the lights and glows; after FRAME.indirectBounces of them its own surroundings
// are the ambient light again. After Kajiya, "The Rendering Equation" (1986), cut there; paths go on.

UINT_CONSTANT(INDIRECT_SALT, 0x626f756eu)
UINT_CONSTANT(DIFFUSED, 0x00800000u)      // in PathState.depth: the path has bounced off a diffuse surface
FLOAT_CONSTANT(INDIRECT_SPREAD, 0.2f)     // radians; the ray stands for a wide cone, so textures take a coarse level
FLOAT_CONSTANT(SKY_SPREAD, 0.02f)         // the same for the surroundings, whose levels are not even over the sphere

#define BOUNCES_DIFFUSE (HAS(EFFECT_INDIRECT_LIGHT) || HAS(EFFECT_PATH))

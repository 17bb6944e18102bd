// One row per kind of ray that is counted, in the order of every list of them: RAY_KIND(number, NAME, name, "word").
// word: in JSON, figures and metrics. The including file defines RAY_KIND; the table undefines it.
RAY_KIND(0u, PRIMARY, primary, "primary")
RAY_KIND(1u, SHADOW, shadow, "shadow")
RAY_KIND(2u, AMBIENT_OCCLUSION, ambientOcclusion, "ambient_occlusion")
RAY_KIND(3u, REFLECTION, reflection, "reflection")
RAY_KIND(4u, REFRACTION, refraction, "refraction")
#undef RAY_KIND

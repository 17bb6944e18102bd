#pragma once
// The functions behind the catalogue's rows.

#include "tests/hard/catalogue.h"

namespace heliograph::hard {

void farSpheres(Run& run);
void tangentSpheres(Run& run);
void insideSpheres(Run& run);
void watertightEdges(Run& run);
void vertexHits(Run& run);
void doubleHits(Run& run);
void grazing(Run& run);
void hugeTriangle(Run& run);
void coplanar(Run& run);
void contact(Run& run);
void axisAligned(Run& run);
void extremes(Run& run);

}  // namespace heliograph::hard

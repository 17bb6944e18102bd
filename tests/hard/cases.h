#pragma once
// The functions behind the catalogue's rows.

#include "tests/hard/catalogue.h"

namespace heliograph::hard {

/// Reads a block of mutated files; ends the process where a reader dies. For hostileFiles.
int readMutations(uint64_t first);

void hostileFiles(Run& run);
void farSpheres(Run& run);
void hugeSphere(Run& run);
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
void farOrigin(Run& run);
void tinyScene(Run& run);
void scaleSweep(Run& run);
void criticalAngle(Run& run);
void bentNormals(Run& run);
void textureCoordinates(Run& run);
void environmentPoles(Run& run);
void fieldOfView(Run& run);
void accumulation(Run& run);
void sampler(Run& run);
void indexNearOne(Run& run);
void slabEnergy(Run& run);
void nestedGlass(Run& run);
void absorption(Run& run);
void parallelMirrors(Run& run);
void furnace(Run& run);
void slivers(Run& run);
void terminator(Run& run);
void badAttributes(Run& run);
void transformed(Run& run);
void corners(Run& run);
void lightsOnSurfaces(Run& run);
void cameraOnSurface(Run& run);
void containment(Run& run);
void devicesAgree(Run& run);

}  // namespace heliograph::hard

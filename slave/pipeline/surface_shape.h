// The deformed surface that the eyes' points tell, for those who watch it.
#pragma once

#include "slave/pipeline/slave.h"
#include "slave/pipeline/surface_estimator.h"

namespace palpate {

// Triangles of the model's surface at rest and displaced, frame S [m]; forces of the tool on their
// nodes [N] if asked for and known.
BoundaryShape MakeSurfaceShape(SurfaceEstimator& estimator, bool nodal_forces);

}  // namespace palpate

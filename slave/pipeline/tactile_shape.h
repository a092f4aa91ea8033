// The object's surface as fingertips deform it, for those who watch it.
#pragma once

#include "slave/pipeline/slave.h"
#include "slave/pipeline/tactile_estimator.h"

namespace palpate {

// Triangles, nodes at rest and displaced, frame S [m]; if asked for, the forces of all fingertips
// on the nodes [N], each shared among the nodes of its triangle by the weights of its place there.
// Empty where nothing deforms.
BoundaryShape MakeTactileShape(TactileEstimator& estimator, bool nodal_forces);

}  // namespace palpate

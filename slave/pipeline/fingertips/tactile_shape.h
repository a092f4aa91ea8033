// The object's surface as fingertips deform it, for those who watch it.
#pragma once

#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Triangles, nodes at rest and displaced, frame S [m]; if asked for, the forces of all fingertips
// on the nodes [N]: those that are felt, whether they or displacements deform the object, each
// spread over the nodes as the model spreads a load at its place. They add up to minus the forces
// of those fingertips that have a place on the object; none are told where one of these is unknown.
// Empty where nothing deforms.
BoundaryShape MakeTactileShape(TactileEstimator& estimator, bool nodal_forces);

}  // namespace palpate

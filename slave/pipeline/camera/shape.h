// The deformed boundary for those who watch it.
#pragma once

#include <Eigen/Geometry>

#include "slave/pipeline/camera/estimator.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Boundary vertices at rest and displaced, frame S [m]; a vertex moves with the mean of its two
// elements. Forces of the tool on the touched place's two vertices [N] if asked for.
BoundaryShape MakeShape(TouchModel& touch, const Eigen::Isometry3d& X_SO,
                        const ContactEstimate& felt, bool nodal_forces);

}  // namespace palpate

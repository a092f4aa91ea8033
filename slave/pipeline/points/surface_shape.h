// The deformed or moved surface that the eyes' points tell, for those who watch it.
#pragma once

#include "slave/pipeline/points/surface_estimator.h"
#include "slave/pipeline/teleop/slave.h"

namespace palpate {

// Triangles of the model's surface at rest and displaced, frame S [m]; forces of the tool on their
// nodes [N] if asked for and known.
BoundaryShape MakeSurfaceShape(SurfaceEstimator& estimator, const ContactEstimate& felt,
                               bool nodal_forces);

// Of an object that is followed as a whole, without a model: the surface of the scene's mesh, frame
// O. Empty where the scene has none. Throws std::invalid_argument (file:line) as ReadMeshFile does.
SurfaceMesh FollowedSurface(const Scene& scene);
// That surface moved by `moved` [m], frame S.
BoundaryShape MakeFollowedShape(const SurfaceMesh& surface, const Eigen::Isometry3d& X_SO,
                                const ContactEstimate& felt, const Eigen::Vector3d& moved);

}  // namespace palpate

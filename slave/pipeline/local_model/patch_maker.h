// Builds the surface patch for the master: the surface at rest and its stiffness, independent of
// the model behind it.
#pragma once

#include <functional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "shared/state/surface_patch.h"
#include "slave/mesh/outline.h"

namespace palpate {

// Stiffness of the object under the tool at rest, frame S [N/m]; zero: unknown. `p_O`: a point [m]
// on the element or triangle `cell`.
using StiffnessAtPlace = std::function<Eigen::Matrix3d(const Eigen::Vector3d& p_O, int cell,
                                                       const Eigen::Vector3d& n_S)>;

// Makes a patch from the elements around `element`, as many on either side as nodes are permitted;
// each element is a node at its midpoint. False: no stiffness is known; an unknown one uses the
// nearest known one. `frictionless`: compliance along the normals only.
bool FillPatch(const BoundaryMesh& mesh, int element, const Eigen::Isometry3d& X_SO,
               bool frictionless, const StiffnessAtPlace& stiffness, SurfacePatch* patch);

// The triangles around p_O, as many as possible; the vertices with the best spread are nodes, those
// next to p_O first, and the others use the nearest node. O(nodes log nodes).
bool FillPatch(const SurfaceMesh& surface, const Eigen::Vector3d& p_O,
               const Eigen::Isometry3d& X_SO, bool frictionless, const StiffnessAtPlace& stiffness,
               SurfacePatch* patch);

}  // namespace palpate

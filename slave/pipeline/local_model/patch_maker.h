// Makes the patch that travels of what a sense knows: the surface at rest, and how stiff it is at a
// place. Which model stands behind it does not matter here.
#pragma once

#include <functional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/outline.h"
#include "shared/mesh/solid_mesh.h"
#include "shared/state/surface_patch.h"

namespace palpate {

// Stiffness of the object under the tool at rest, frame S [N/m]; zero: nobody can tell. `p_O`: a
// place [m] on the element or triangle `cell`.
using StiffnessAtPlace = std::function<Eigen::Matrix3d(const Eigen::Vector3d& p_O, int cell,
                                                       const Eigen::Vector3d& n_S)>;

// The elements around `element`, as many to either side as nodes allow; each is a node at its
// middle. False: the stiffness of none of them is known; one that is not goes by the nearest that
// is. `frictionless`: compliance along the normals only.
bool FillPatch(const BoundaryMesh& mesh, int element, const Eigen::Isometry3d& X_SO,
               bool frictionless, const StiffnessAtPlace& stiffness, SurfacePatch* patch);

// The triangles around p_O, as many as there may be; the vertices that spread best are nodes, those
// next to p_O before all, the others go by the nearest of them. O(nodes log nodes).
bool FillPatch(const SurfaceMesh& surface, const Eigen::Vector3d& p_O,
               const Eigen::Isometry3d& X_SO, bool frictionless, const StiffnessAtPlace& stiffness,
               SurfacePatch* patch);

}  // namespace palpate

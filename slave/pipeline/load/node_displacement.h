// A model's answer as displacements of its surface's nodes.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

// Of every node of `surface` under the contacts of the last Respond, frame O [m]; where the model
// knows triangles only, the mean of those at the node.
void NodeDisplacement(DeformationModel& model, const SurfaceMesh& surface,
                      std::vector<Eigen::Vector3d>* u_O);

}  // namespace palpate

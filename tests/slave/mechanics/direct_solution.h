// An independent formulation for comparison with linear tetrahedra: strain-displacement matrices in
// Voigt's notation, a dense stiffness in SI, supports and contacts by Lagrange multipliers, one LU
// factorisation.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/deformation_model.h"

namespace palpate {

struct Body {
  SolidMesh mesh;
  std::vector<std::array<bool, 3>> held;
  double E = 0;   // [Pa]
  double nu = 0;  // [-]
};

// Makes a body fixed on the plane of the smallest coordinate along `axis`.
Body Standing(SolidMesh mesh, int axis, double E, double nu);
// A box of some cells with its inner nodes shaken, standing on z = 0.
Body ShakenBox(std::array<int, 3> cells, double E, double nu);
// One of the foam meshes (`cube`, `bar`, `sponge`); empty where the file is absent.
SolidMesh FoamMesh(const std::string& name);

// Stiffness of one tetrahedron, node by node [N/m].
Eigen::Matrix<double, 12, 12> VoigtStiffness(const SolidMesh& mesh, const std::array<int, 4>& tet,
                                             double E, double nu);

struct DirectAnswer {
  std::vector<Eigen::Vector3d> displacement_O;  // per node [m]
  std::vector<Eigen::Vector3d> force_O;         // per contact [N]
  std::vector<Eigen::Vector3d> mean_O;          // displacement per contact, weighted as a load [m]
};
// The nodes of a contact come from FindPlace and PatchAt, those of a flat tool and the springs at
// its rim from SurfaceFootprints. `whole_nodes`: the nodes within the
// tool, without rim. All nodes of a tool are glued to it.
DirectAnswer SolveDirectly(const Body& body, std::span<const Contact> contacts, bool frictionless,
                           bool whole_nodes);

}  // namespace palpate

// Stiffness of a linear-elastic tetrahedral mesh with fixed components left out.
//
// Nondimensional: lengths by length_unit, moduli by E of the body, which each tetrahedron's modulus
// multiplies, so K = K_SI / (E length_unit). Small strain,
// displacement formulation: locks as nu -> 0.5 (tet4 from about 0.45 on, tet10 from about 0.49 on).
// Source: Zienkiewicz and Taylor, The Finite Element Method, ch. 6 (tetrahedra, volume
// coordinates).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/SparseCore>

#include "shared/mesh/solid_mesh.h"

namespace palpate {

enum class TetElement : std::uint8_t {
  kTet4,  // constant strain
  kTet10  // straight edges with a node in the middle, linear strain, quadrature exact
};

struct TetStiffness {
  // Symmetric positive definite, its lower triangle only. Rows go node by node, the nodes of the
  // mesh first, then the middles of edges.
  Eigen::SparseMatrix<double> lower;
  std::vector<std::array<int, 3>> row;  // per node and component; -1: fixed, or in no tetrahedron
  double length_unit = 0;               // larger side of the bounding box [m]
  std::uint64_t inputs = 0;             // hash of all that it was assembled from
};

// `held`: per node of the mesh and component; a middle is fixed where both ends are. Throws
// std::invalid_argument: counts that do not fit, a tetrahedron without positive volume or with a
// node that does not exist, nu not in (-1, 0.499], supports that leave a part of the body free to
// move.
TetStiffness AssembleTetStiffness(const SolidMesh& mesh, const HeldNodes& held, double nu,
                                  TetElement element);

}  // namespace palpate

// Stiffness at rest of a linear-elastic tetrahedral mesh, with fixed components left out, and its
// factor.
//
// Nondimensional: lengths are divided by length_unit, moduli by E of the body, and each tetrahedron
// has a relative modulus, so K = K_SI / (E length_unit). Small strain. From nu = 0.4 on every
// corner has a pressure unknown, stabilised in four-node elements (ElasticBody), so that none
// locks.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/linear/sparse_ldlt.h"
#include "slave/mechanics/linear/spd_factor.h"
#include "slave/mechanics/tet_mesh.h"
#include "slave/scene/scene.h"

namespace palpate {

struct RestStiffness {
  TetMesh elements;  // its nodes are divided by length_unit
  // Symmetric, the lower triangle: positive definite without pressure, else indefinite.
  Eigen::SparseMatrix<double> lower;
  // The stiffness with pressure, compressible enough to be factored without pivoting
  // (ElasticBody::kMinCompressibility); empty without pressure.
  Eigen::SparseMatrix<double> regularised;
  std::vector<std::array<int, 3>> row;  // per node and component; -1: fixed, or in no tetrahedron
  HeldNodes held;                       // per node of the mesh and component
  double poisson_ratio = 0;
  double length_unit = 0;    // larger side of the bounding box [m]
  std::uint64_t inputs = 0;  // hash of all that it was assembled from

  [[nodiscard]] bool has_pressure() const { return regularised.rows() > 0; }
  [[nodiscard]] Elements kind() const {
    if (elements.nodes_per_element == 10) return Elements::kTenNodes;
    return has_pressure() ? Elements::kFourNodesMixed : Elements::kFourNodes;
  }
  // The displacement of every node of the elements, as far as it is free, from a solution's rows.
  void Spread(const Eigen::Ref<const Eigen::VectorXd>& x, std::vector<Eigen::Vector3d>* u) const;
};

// `held`: per node of the mesh and component; a mid-edge node is fixed if both ends are. Throws
// std::invalid_argument: counts that do not fit, a tetrahedron without positive volume or with a
// node that does not exist, nu not in (-1, 0.5], supports
// that leave a part of the body free to move.
RestStiffness AssembleAtRest(const SolidMesh& mesh, const HeldNodes& held, double nu,
                             FemOptions::Element element);

// The factor of a RestStiffness. Not thread-safe.
class RestFactor {
 public:
  // Stores a reference to its argument. Throws: see SpdFactor; std::invalid_argument: a pivot is
  // zero.
  explicit RestFactor(const RestStiffness& stiffness);

  // Each column becomes K^-1 times it, with pressure to a residual of 1e-12.
  void Solve(Eigen::Ref<Eigen::MatrixXd> columns);
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  const RestStiffness& stiffness_;
  std::optional<SpdFactor> definite_;
  std::optional<SparseLdlt<double>> mixed_;
};

}  // namespace palpate

// A linear-elastic body with its factor: what surrounds a zone, condensed exactly onto the zone's
// border, and whole-body solutions.
//
// With G = K^-1 of the whole body, b the border's unknowns and S_zone the Schur complement of the
// zone's own linear tetrahedra onto b, the rest of the body acts on b as
//
//   S_rest = (G_bb)^-1 - S_zone
//
// Nondimensional as TetStiffness: lengths by the larger side, moduli by E.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/green/tet_stiffness.h"
#include "slave/mechanics/fem/zone/zone.h"
#include "slave/mechanics/linear/mumps.h"

namespace palpate {

class LinearRest {
 public:
  // Factorises. Throws: see AssembleTetStiffness, SpdFactor.
  LinearRest(const SolidMesh& mesh, const HeldNodes& held, double nu);

  // S_rest of every zone: three rows and columns per node of its border, those of held components
  // zero. Zones that share nodes are cheapest together. O(border nodes) whole-body solutions.
  // Throws std::bad_alloc, std::runtime_error: no memory, or not positive definite.
  std::vector<Eigen::MatrixXd> Condense(const std::vector<Zone>& zones);

  // K^-1 times each column of forces, three numbers per node; held components zero.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& forces);

  [[nodiscard]] double length_unit() const { return stiffness_.length_unit; }
  [[nodiscard]] bool is_held(int node, int component) const { return Row(node, component) < 0; }
  [[nodiscard]] std::size_t memory_bytes() const;
  // The matrix and its rows, from which a hash recognises the body.
  [[nodiscard]] const TetStiffness& stiffness() const { return stiffness_; }

 private:
  [[nodiscard]] int Row(int node, int component) const {
    return stiffness_.row[static_cast<std::size_t>(node)][static_cast<std::size_t>(component)];
  }
  void AddCompliances(const std::vector<Zone>& zones, std::vector<Eigen::MatrixXd>* G);
  [[nodiscard]] Eigen::MatrixXd ZoneSchur(const Zone& zone) const;

  const SolidMesh& mesh_;
  double nu_;
  TetStiffness stiffness_;
  SpdFactor factor_;
};

}  // namespace palpate

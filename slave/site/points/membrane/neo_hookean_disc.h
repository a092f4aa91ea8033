// Elastic forces and stiffness of a thick plate of neo-Hookean rubber, without any assumption on
// its kinematics: cubic hexahedra over half of it or a quarter, between mirror planes.
#pragma once

#include <Eigen/Core>

#include "slave/site/points/membrane/disc_mesh.h"
#include "slave/site/solid/neo_hookean_body.h"

namespace palpate::site {

class NeoHookeanDisc {
 public:
  using Matrix = NeoHookeanBody::Matrix;

  // Keeps a reference to the mesh. -1 < nu < 0.5; `tension` at rest in the plate's plane, >= 0.
  NeoHookeanDisc(const DiscMesh& mesh, double nu, double tension = 0);

  // Unknowns: column by column of the mesh, upward, x, y, z.
  [[nodiscard]] int size() const { return body_.size(); }
  [[nodiscard]] int unknown(int column, int level, int component) const {
    return 3 * (mesh_.levels() * column + level) + component;
  }
  // As NeoHookeanBody; where the mirror planes hold, forces are zero and the stiffness is one.
  bool Forces(const Eigen::VectorXd& u, Eigen::VectorXd* forces) const;
  bool Linearise(const Eigen::VectorXd& u, Eigen::VectorXd* forces, Matrix* stiffness) const;
  [[nodiscard]] Matrix EmptyMatrix() const { return body_.EmptyMatrix(); }
  // Load of one along -z, spread evenly over the outer face below the tool.
  [[nodiscard]] Eigen::VectorXd ToolLoad() const;

 private:
  const DiscMesh& mesh_;
  NeoHookeanBody body_;
  Eigen::VectorXd free_;  // 0 for what the mirror planes hold, else 1
};

}  // namespace palpate::site

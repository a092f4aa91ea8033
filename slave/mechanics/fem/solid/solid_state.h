// The unknowns of a solid and the loads on them. Nondimensional: lengths are divided by the larger
// side, forces by E times its square.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/solid/equilibrium.h"

namespace palpate {

struct SolidState {
  Eigen::VectorXd x;               // displacements and pressures
  Balance balance;                 // fixed unknowns, and the rows of moved points
  Eigen::VectorXd target;          // prescribed displacements of fixed unknowns
  Eigen::VectorXd loads;           // gravity included
  std::vector<double> row_target;  // prescribed displacements of moved points

  // Resets to rest without moved points.
  void Rest() {
    x.setZero();
    balance.row_force.setZero();
  }
};

}  // namespace palpate

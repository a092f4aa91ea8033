// Motion of a solid in steps of time: implicit Euler.
#pragma once

#include <Eigen/Core>

#include "slave/mechanics/fem/solid/elastic_body.h"
#include "slave/mechanics/fem/solid/equilibrium.h"
#include "slave/mechanics/fem/solid/solid_state.h"
#include "slave/scene/scene.h"

namespace palpate {

class SolidMotion {
 public:
  // Stores references to the equilibrium and the state, to whose balance it adds the inertia.
  // `density`: divided by E and multiplied by the square of the length unit [s^2].
  SolidMotion(const FemOptions& options, const BlockLayout& layout, const ElasticBody& body,
              double density, Equilibrium& equilibrium, SolidState& state);

  // Puts the body at rest.
  void Reset();
  // Advances the state by a step under its loads. False: no solution, the state is as before.
  bool Step();
  // Restores the state before the last step.
  void TakeBack();

  // Returns whether the last step increased the energy by more than the work of loads and moved
  // nodes.
  [[nodiscard]] bool grew() const { return grew_; }
  // Elastic plus kinetic energy, divided by E times the length unit cubed.
  [[nodiscard]] double Energy();

 private:
  void Prepare();
  [[nodiscard]] bool EnergyGrew();
  [[nodiscard]] bool linear() const { return options_.law == FemOptions::Law::kLinear; }

  FemOptions options_;
  Equilibrium& equilibrium_;
  SolidState& state_;
  SparseMatrix mass_, inertia_;  // M, Q = M / h^2
  Eigen::VectorXd velocity_, product_;
  Eigen::VectorXd start_, start_velocity_, start_row_force_;  // of the step
  bool grew_ = false;
  double start_energy_ = 0;
};

}  // namespace palpate

// Parameters of a solid model, and the combinations that it accepts.
#pragma once

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/solid/equilibrium.h"
#include "slave/mechanics/fem/solid/sparse_system.h"
#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

struct SolidParams {
  FemOptions options;
  double young_modulus = 0;  // E [Pa]
  double poisson_ratio = 0;  // -1 < nu <= 0.5
  double density = 0;        // [kg/m^3], > 0 where there is gravity or time
  double range = 0.1;        // of the linear law: largest |displacement| / larger side
  SymmetricSolver::Limits limits;

  [[nodiscard]] bool dynamic() const { return options.time == FemOptions::Time::kDynamic; }
  [[nodiscard]] bool linear() const { return options.law == FemOptions::Law::kLinear; }
  [[nodiscard]] int nodes_per_element() const {
    return options.element == FemOptions::Element::kTet10 ? 10 : 4;
  }
  // Returns whether the pressure is a separate unknown: for ten-node elements from nu = 0.49 on.
  // Otherwise it follows from the displacement, which locks as nu -> 0.5.
  [[nodiscard]] bool HasPressureUnknown() const;
  // Settings of Newton's method; `progress` serves it at rest.
  [[nodiscard]] Equilibrium::Options SolverOptions(fem::SearchProgress* progress) const;
};

// Returns `params`. Throws std::invalid_argument: an impossible parameter or combination.
// nu is at most kNearlyIncompressible, with a pressure unknown and the linear law 0.5.
SolidParams Checked(const SolidParams& params);
inline constexpr double kNearlyIncompressible = 0.49999;

// Reports a rough expectation of time and memory, before anything is built.
void Announce(const SolidMesh& mesh, const SolidParams& params, Progress* progress);

}  // namespace palpate

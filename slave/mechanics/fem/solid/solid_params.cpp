#include "slave/mechanics/fem/solid/solid_params.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Element = FemOptions::Element;
using Law = FemOptions::Law;

constexpr double kMixedFrom = 0.49;  // nu from which ten-node elements have a pressure unknown
constexpr double kFactorOnce = 3e8;  // largest cost of a factorisation in every step [operations]

void CheckPressure(const SolidParams& params) {
  const auto& o = params.options;
  const double nu = params.poisson_ratio;
  if (!params.HasPressureUnknown()) {
    if (nu <= kNearlyIncompressible) return;
    RefuseValue("poisson_ratio", nu, "at most 0.49999 with element = tet4");
  }
  if (o.law != Law::kLinear && nu > kNearlyIncompressible) {
    RefuseValue("poisson_ratio", nu, "at most 0.49999 unless law = linear");
  }
}

}  // namespace

bool SolidParams::HasPressureUnknown() const {
  return options.element == Element::kTet10 && poisson_ratio >= kMixedFrom;
}

SolidParams Checked(const SolidParams& params) {
  const auto& o = params.options;
  RequirePositive("young_modulus", params.young_modulus);
  RequirePositive("range", params.range);
  RequirePositive("residual", o.residual);
  if (o.residual > 0.1) RefuseValue("residual", o.residual, "at most 0.1");
  if (!(params.poisson_ratio > -1 && params.poisson_ratio <= 0.5)) {
    RefuseValue("poisson_ratio", params.poisson_ratio, "-1 < nu <= 0.5");
  }
  if (!o.gravity_O.allFinite()) throw std::invalid_argument("gravity: expected finite numbers");
  if (o.time == FemOptions::Time::kDynamic || !o.gravity_O.isZero(0))
    RequirePositive("density", params.density);
  if (o.time == FemOptions::Time::kDynamic) RequirePositive("step", o.step);
  CheckPressure(params);
  return params;
}

Equilibrium::Options SolidParams::SolverOptions(fem::SearchProgress* progress) const {
  Equilibrium::Options solver;
  solver.residual = options.residual;
  solver.limits = limits;
  if (dynamic()) {
    solver.one_solve = true;
    return solver;
  }
  solver.progress = progress;
  if (!linear()) {
    solver.limits.iterated_flops = std::min(limits.iterated_flops, kFactorOnce);
  }
  return solver;
}

// Announces an estimate of time and memory before anything is built: factors of three-dimensional
// meshes grow as n^(4/3).
void Announce(const SolidMesh& mesh, const SolidParams& params, Progress* progress) {
  if (!progress) return;
  const bool quadratic = params.options.element == Element::kTet10;
  const double nodes = static_cast<double>(mesh.nodes.size()) * (quadratic ? 7.5 : 1);
  const double entries = std::min(30 * std::pow(3 * nodes, 4.0 / 3), 1.8e8);
  const double matrix = 3 * nodes * (quadratic ? 45 : 25);
  progress->Expect({1e-5 * static_cast<double>(mesh.tets.size()) * (quadratic ? 4 : 1) +
                        entries * std::sqrt(entries) * 2e-10,
                    static_cast<std::size_t>(12 * (entries + 5 * matrix))});
  ReportProgress(progress, "mesh and pattern", 0);
}

}  // namespace palpate

#include "slave/mechanics/fem/solid/solid_motion.h"

#include <algorithm>
#include <cmath>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::VectorXd;

// Accepted growth of the energy per step, since one linear solve does not minimise it.
constexpr double kGrowth = 1e-2;

}  // namespace

SolidMotion::SolidMotion(const FemOptions& options, const BlockLayout& layout,
                         const ElasticBody& body, double density, Equilibrium& equilibrium,
                         SolidState& state)
    : options_(options),
      equilibrium_(equilibrium),
      state_(state),
      mass_(layout.pattern()),
      inertia_(mass_) {
  velocity_ = start_ = start_velocity_ = product_ = VectorXd::Zero(layout.size());
  body.AddMass(density, &mass_);
  const auto values = [](SparseMatrix& m) {
    return Eigen::Map<VectorXd>(m.valuePtr(), m.nonZeros());
  };
  values(inertia_) = 1 / (options.step * options.step) * values(mass_);
  state_.balance.inertia = &inertia_;
  state_.balance.origin = &start_;
}

void SolidMotion::Reset() {
  velocity_.setZero();
}

// Sets the inertia's share of the load from the state at the start of the step.
void SolidMotion::Prepare() {
  start_ = state_.x;
  start_velocity_ = velocity_;
  start_row_force_ = state_.balance.row_force;
  Multiply(mass_, velocity_, &product_);
  state_.balance.force = state_.loads + product_ / options_.step;
}

bool SolidMotion::Step() {
  const bool checks_energy = !linear();
  if (checks_energy) start_energy_ = Energy();
  Prepare();
  state_.balance.given = state_.target;
  for (std::size_t k = 0; k < state_.balance.rows.size(); ++k)
    state_.balance.rows[k].value = state_.row_target[k];
  if (!equilibrium_.Solve(&state_.balance, &state_.x)) {
    TakeBack();
    return false;
  }
  velocity_ = (state_.x - start_) / options_.step;
  grew_ = checks_energy && EnergyGrew();
  return true;
}

void SolidMotion::TakeBack() {
  state_.x = start_;
  velocity_ = start_velocity_;
  state_.balance.row_force = start_row_force_;
}

double SolidMotion::Energy() {
  Multiply(mass_, velocity_, &product_);
  return equilibrium_.Energy(state_.x) + 0.5 * velocity_.dot(product_);
}

bool SolidMotion::EnergyGrew() {
  const double energy = Energy();
  double work = 0, given = 0;
  for (int i = 0; i < state_.x.size(); ++i) {
    const double moved = state_.x[i] - start_[i];
    const double carried = state_.balance.fixed[Index(i)] ? equilibrium_.unbalanced()[i] : 0;
    work += (state_.loads[i] + carried) * moved;
    given += std::abs((state_.loads[i] + carried) * moved);
  }
  for (std::size_t k = 0; k < state_.balance.rows.size(); ++k) {
    for (const auto& [unknown, weight] : state_.balance.rows[k].weights) {
      const double part = state_.balance.row_force[static_cast<int>(k)] * weight *
                          (state_.x[unknown] - start_[unknown]);
      work += part;
      given += std::abs(part);
    }
  }
  return energy - start_energy_ - work > kGrowth * (start_energy_ + given);
}

}  // namespace palpate

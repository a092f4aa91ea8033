#include "slave/mechanics/fem/solid/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::VectorXd;

constexpr int kMaxNewtonSteps = 60;  // of Newton's method
constexpr int kMaxRefinements = 60;
constexpr int kMaxHalvings = 40;
constexpr double kMinRemoved = 1.0 / 64;  // of negative curvature, if any
constexpr double kVolume = 1e-8;          // change of volume by displacement that counts as zero
constexpr double kArmijo = 1e-4;
constexpr double kRounding = 1e-14;   // of energies and forces
constexpr double kStartShare = 1e-6;  // of the initial forces, as a scale of the residual
constexpr int kRowRefinements = 8;
// Largest residual after an iterated step, relative to that before.
constexpr double kMaxForcing = 1e-2;
constexpr double kAim = 1e-2;     // target relative to the requested residual, for iterated steps
constexpr double kTight = 1e-11;  // residual that one direct solve reaches

// Returns whether fixed unknowns and points are at their prescribed values.
bool Feasible(const Balance& balance, const VectorXd& x) {
  for (int i = 0; i < x.size(); ++i) {
    if (balance.fixed[Index(i)] && x[i] != balance.given[i]) return false;
  }
  return balance.rows.empty();
}

// Computes energy and force of inertia. `moved` is working memory.
double Inertia(const Balance& balance, const VectorXd& x, VectorXd* moved, VectorXd* force) {
  *moved = x - *balance.origin;
  Multiply(*balance.inertia, *moved, force);
  return 0.5 * moved->dot(*force);
}

}  // namespace

Equilibrium::Equilibrium(const BlockLayout& layout, const ElasticBody& body, const Options& options)
    : layout_(layout),
      body_(body),
      options_(options),
      solver_(layout.pattern(), options.limits,
              layout.has_pressure() ? std::vector<Eigen::Vector3d>{} : layout.Points(),
              options.progress),
      stiffness_(layout.pattern()),
      system_(layout.pattern()) {
  const VectorXd rest = VectorXd::Zero(layout.size());
  residual_ = right_ = step_ = trial_ = product_ = rest;
  if (linear()) body_.AddTangent(rest, kExactTangent, false, &stiffness_);
  if (layout.has_pressure() && !linear()) pressure_.emplace(layout, body);
}

double Equilibrium::Energy(const VectorXd& x) {
  if (!linear()) return body_.Energy(x);
  Multiply(stiffness_, x, &product_);
  return 0.5 * x.dot(product_);
}

// Fills residual_ and returns the potential energy: elastic, of the loads, of inertia.
double Equilibrium::Residual(const Balance& balance, const VectorXd& x) {
  double energy = 0;
  if (linear()) {
    Multiply(stiffness_, x, &residual_);
    energy = 0.5 * x.dot(residual_);
  } else {
    energy = body_.Energy(x, &residual_);
  }
  energy -= balance.force.dot(x);
  residual_ -= balance.force;
  if (balance.inertia) {
    energy += Inertia(balance, x, &trial_, &product_);
    residual_ += product_;
  }
  return energy;
}

double Equilibrium::Potential(const Balance& balance, const VectorXd& x) {
  const double energy = body_.Energy(x) - balance.force.dot(x);
  return balance.inertia ? energy + Inertia(balance, x, &right_, &product_) : energy;
}

// Computes the residual on free unknowns, relative to the present forces.
double Equilibrium::Weigh(const Balance& balance) {
  right_ = -residual_;
  double carried = 0;
  for (int i = 0; i < right_.size(); ++i) {
    if (balance.fixed[Index(i)]) {
      carried += right_[i] * right_[i];
      right_[i] = 0;
    }
  }
  double points = 0;
  for (std::size_t k = 0; k < balance.rows.size(); ++k) {
    const double m = balance.row_force[static_cast<int>(k)];
    for (const auto& [unknown, weight] : balance.rows[k].weights) {
      if (!balance.fixed[Index(unknown)]) right_[unknown] += weight * m;
    }
    points += m * m;
  }
  const double scale = std::max({balance.force.stableNorm(), std::sqrt(carried), std::sqrt(points),
                                 kStartShare * start_force_});
  const double left = right_.stableNorm();
  if (left <= std::numeric_limits<double>::min()) return 0;
  return scale > 0 ? left / scale : std::numeric_limits<double>::infinity();
}

// Rows and columns of fixed unknowns become those of the identity; for the rows of points C^T C
// times a stiffness is added, so that they are definite.
void Equilibrium::Constrain(const Balance& balance) {
  rows_.penalty = system_.diagonal().cwiseAbs().maxCoeff();
  for (const auto& row : balance.rows) {
    for (const auto& [i, weight_i] : row.weights) {
      for (const auto& [j, weight_j] : row.weights) {
        if (i <= j) system_.coeffRef(i, j) += rows_.penalty * weight_i * weight_j;
      }
    }
  }
  for (int column = 0; column < system_.cols(); ++column) {
    const bool fixed_column = balance.fixed[Index(column)];
    for (SparseMatrix::InnerIterator entry(system_, column); entry; ++entry) {
      if (fixed_column || balance.fixed[static_cast<std::size_t>(entry.row())]) {
        entry.valueRef() = entry.row() == column ? rows_.penalty : 0;
      }
    }
  }
}

bool Equilibrium::PrepareRows(const Balance& balance) {
  const int count = static_cast<int>(balance.rows.size());
  if (!rows_.has_columns) rows_.columns.setZero(layout_.size(), count);
  rows_.has_columns = true;
  rows_.matrix.resize(count, count);
  for (int k = 0; k < count; ++k) {
    right_.setZero();
    for (const auto& [unknown, weight] : balance.rows[Index(k)].weights) {
      if (!balance.fixed[Index(unknown)]) right_[unknown] = weight;
    }
    step_ = rows_.columns.col(k);
    if (!solver_.Solve(right_, linear() ? 0.01 * options_.residual : Accuracy(), &step_)) {
      rows_.has_columns = false;
      return Fail("the linear solver did not converge");
    }
    rows_.columns.col(k) = step_;
  }
  for (int k = 0; k < count; ++k) {
    for (int l = 0; l < count; ++l) {
      double sum = 0;
      for (const auto& [unknown, weight] : balance.rows[Index(k)].weights) {
        if (!balance.fixed[Index(unknown)]) sum += weight * rows_.columns(unknown, l);
      }
      rows_.matrix(k, l) = sum;
    }
  }
  rows_.matrix = (0.5 * (rows_.matrix + rows_.matrix.transpose())).eval();
  rows_.factor.emplace(rows_.matrix);
  const auto pivots = rows_.factor->vectorD();
  if (!(pivots.minCoeff() > 1e-10 * pivots.maxCoeff())) {
    return Fail("prescribed displacements contradict each other or the fixed nodes of the scene");
  }
  return true;
}

bool Equilibrium::FactorTangent(const Balance& balance, const VectorXd& x, const Tangent& tangent,
                                bool first) {
  std::copy_n(layout_.pattern().valuePtr(), system_.nonZeros(), system_.valuePtr());
  const bool regularise = layout_.has_pressure();
  body_.AddTangent(x, tangent, regularise, &system_);
  if (balance.inertia) {
    Eigen::Map<VectorXd>(system_.valuePtr(), system_.nonZeros()) +=
        Eigen::Map<const VectorXd>(balance.inertia->valuePtr(), system_.nonZeros());
  }
  if (!linear() && first) {
    std::copy_n(system_.valuePtr(), system_.nonZeros(), stiffness_.valuePtr());
  }
  Constrain(balance);
  return solver_.Factorize(system_, !layout_.has_pressure(), balance.fixed, steps_ == 0);
}

// Relative residual of a linear solve that suffices for the next step of Newton's method.
double Equilibrium::Accuracy() const {
  if (linear()) return 0.1 * options_.residual;
  const double enough = std::min(kMaxForcing, kAim * options_.residual / relative_);
  return std::max(std::min(kMaxForcing, relative_), enough);
}

// Newton's step with a tangent that has as many negative curvatures as free pressures, so that it
// descends. The remaining negative curvature is removed, as little as makes the tangent definite;
// the more is removed, the slower the convergence.
bool Equilibrium::Prepare(Balance* balance, const VectorXd& x, bool first) {
  if (linear() && factored_) {
    Weigh(*balance);
    return Direction(balance, x, first);
  }
  expected_negative_ = 0;
  for (int i = 0; i < layout_.pressures(); ++i) {
    expected_negative_ += !balance->fixed[Index(layout_.pressure(i))];
  }
  const auto stepped = [&](const Tangent& tangent) {
    factored_ = FactorTangent(*balance, x, tangent, first) &&
                (!solver_.is_direct() || solver_.negative_pivots() == expected_negative_);
    if (!factored_) {
      return Fail("the stiffness is not positive: the body is free to move or has collapsed");
    }
    if (!balance->rows.empty() && !PrepareRows(*balance)) return false;
    Weigh(*balance);  // PrepareRows used right_
    return Direction(balance, x, first);
  };
  if (linear() || options_.one_solve) return stepped(linear() ? kExactTangent : kWarpedTangent);
  if (!raised_) removed_ = removed_ > kMinRemoved ? removed_ / 4 : 0;
  raised_ = false;
  while (!stepped({removed_, false})) {
    const bool stopped = options_.progress != nullptr && options_.progress->stopped();
    if (stopped || removed_ >= 1 || (factored_ && !solver_.indefinite())) return false;
    removed_ = std::min(1.0, std::max(4 * removed_, kMinRemoved));
    raised_ = !solver_.is_direct();
  }
  return true;
}

// Newton's step, from right_ = minus the residual. The first one moves fixed unknowns to their
// prescribed values.
bool Equilibrium::Direction(Balance* balance, const VectorXd& x, bool first) {
  const VectorXd& r = right_;
  if (first) {
    trial_.setZero();
    for (int i = 0; i < x.size(); ++i) {
      if (balance->fixed[Index(i)]) trial_[i] = balance->given[i] - x[i];
    }
    Multiply(stiffness_, trial_, &product_);
    if (balance->inertia && linear()) {
      Multiply(*balance->inertia, trial_, &step_);
      product_ += step_;
    }
    for (int i = 0; i < x.size(); ++i) {
      if (!balance->fixed[Index(i)]) right_[i] -= product_[i];
    }
  }
  step_.setZero();
  if (!solver_.Solve(r, Accuracy(), &step_)) return Fail("the linear solver did not converge");
  const int count = static_cast<int>(balance->rows.size());
  if (count > 0) {
    VectorXd gap(count), missing(count);
    for (int k = 0; k < count; ++k) {
      const PointRow& row = balance->rows[Index(k)];
      gap[k] = row.value;
      for (const auto& [unknown, weight] : row.weights) {
        gap[k] -= weight * (balance->fixed[Index(unknown)] ? balance->given[unknown] : x[unknown]);
      }
    }
    balance->row_force -= rows_.penalty * gap;
    // Iterated columns are approximate. The prescribed motion of points must be exact, otherwise
    // their forces would do work.
    for (int refinement = 0; refinement < (solver_.is_direct() ? 1 : kRowRefinements);
         ++refinement) {
      missing = gap;
      for (int k = 0; k < count; ++k) {
        for (const auto& [unknown, weight] : balance->rows[Index(k)].weights) {
          if (!balance->fixed[Index(unknown)]) missing[k] -= weight * step_[unknown];
        }
      }
      const VectorXd m = rows_.factor->solve(missing);
      step_ += rows_.columns * m;
      balance->row_force += m;
    }
  }
  if (first) {
    for (int i = 0; i < x.size(); ++i) {
      if (balance->fixed[Index(i)]) step_[i] = trial_[i];
    }
  }
  return step_.allFinite() || Fail("the linear solver broke down");
}

// Backtracks until the energy decreases enough and no element is inverted, because equilibria with
// inverted elements cannot be reached by a slow load. If the change of energy is within rounding,
// the whole step is accepted. A state that is inverted at the beginning may remain so.
bool Equilibrium::Search(const Balance& balance, double slope, VectorXd* x) {
  const double rounding = kRounding * (std::abs(energy_) + std::abs(balance.force.dot(*x)));
  const bool began_inverted = body_.FindJacobians(*x).inverted > 0;
  double length = 1;
  for (int i = 0; i < kMaxHalvings; ++i, length *= 0.5) {
    trial_ = *x + length * step_;
    if (pressure_) pressure_->Update(&trial_);
    const double energy = Potential(balance, trial_);
    if (std::isfinite(energy) && energy <= energy_ + kArmijo * length * slope + rounding &&
        (began_inverted || body_.FindJacobians(trial_).inverted == 0)) {
      x->swap(trial_);
      return true;
    }
  }
  return false;
}

bool Equilibrium::Solve(Balance* balance, VectorXd* x) {
  failure_ = {};
  removed_ = 0;
  raised_ = false;
  if (balance->row_force.size() != static_cast<int>(balance->rows.size())) {
    balance->row_force.setZero(static_cast<int>(balance->rows.size()));
  }
  if (!Iterate(balance, x)) {
    return options_.progress != nullptr && options_.progress->stopped() ? Fail("interrupted")
                                                                        : false;
  }
  return x->allFinite() && x->lpNorm<Eigen::Infinity>() < std::numeric_limits<double>::max();
}

// Returns whether prescribed displacements on the whole surface of an incompressible body keep its
// volume.
bool Equilibrium::KeepsVolume(const VectorXd& x) {
  if (!linear() || !layout_.has_pressure() || body_.law().compressibility() > 0) return true;
  double change = 0, largest = 0;
  for (int i = 0; i < layout_.pressures(); ++i) {
    change += residual_[layout_.pressure(i)];
    largest = std::max(largest, x.segment<3>(layout_.first(i)).lpNorm<Eigen::Infinity>());
  }
  return std::abs(change) <= kVolume * largest + kTight * x.lpNorm<Eigen::Infinity>() ||
         Fail("prescribed displacements change the volume of an incompressible body");
}

bool Equilibrium::Iterate(Balance* balance, VectorXd* x) {
  const bool counted = options_.one_solve && !linear();
  const int most = counted ? 1 : linear() ? kMaxRefinements : kMaxNewtonSteps;
  // With iterative solutions further digits are cheap.
  const double goal = linear() && solver_.is_direct()   ? std::min(kTight, options_.residual)
                      : linear() || solver_.is_direct() ? options_.residual
                                                        : kAim * options_.residual;
  double best = std::numeric_limits<double>::infinity();
  start_force_ = 0;
  int stalled = 0;
  bool moves = !Feasible(*balance, *x);  // the next step brings x to the prescribed values
  for (steps_ = 0;; ++steps_) {
    if (pressure_) pressure_->Update(x);
    energy_ = Residual(*balance, *x);
    if (steps_ == 0) start_force_ = residual_.stableNorm();
    relative_ = Weigh(*balance);
    if (!std::isfinite(energy_) || std::isnan(relative_)) return Fail("the solution is not finite");
    if (!moves && relative_ <= goal && !(counted && steps_ == 0)) return KeepsVolume(*x);
    if (counted && steps_ >= most) return true;
    if (options_.progress != nullptr) {
      options_.progress->Reach(relative_, goal);
      if (!options_.progress->Continue()) return Fail("interrupted");
    }
    stalled = relative_ < 0.9 * best || moves ? 0 : stalled + 1;
    best = std::min(best, relative_);
    if (stalled > 0 && !moves && !linear() && !counted && relative_ <= options_.residual)
      return true;
    if (steps_ >= most || (linear() && stalled > 4)) {
      if (relative_ <= options_.residual) return KeepsVolume(*x);
      return Fail(linear() ? "the linear solver does not reach the requested residual"
                           : "no equilibrium was found: Newton's method did not converge");
    }
    if (!Prepare(balance, *x, moves)) return false;
    if (moves || linear() || counted) {
      *x += step_;
      moves = false;
      continue;
    }
    if (!Search(*balance, std::min(residual_.dot(step_), 0.0), x)) {
      if (relative_ <= options_.residual) return true;
      return Fail("no equilibrium was found: the energy does not decrease further");
    }
  }
}

}  // namespace palpate

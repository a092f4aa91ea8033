#include "slave/mechanics/plate/fit/identify_prestress.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "slave/mechanics/plate/contacts.h"
#include "slave/mechanics/plate/modal_plate.h"
#include "slave/mechanics/plate/plate_modes.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;
using plate::ModalPlate;

constexpr int kIterations = 30;
constexpr double kDifference = 1e-4;  // of the unknowns
constexpr double kConverged = 1e-3;   // step by its standard deviation
constexpr double kKnown = 0.5;        // sigma of a known tension by the tension that matters
constexpr double kKnownShare = 0.3;   // sigma of a known pressure or modulus by itself
// Of the tension that stretching makes: von Karman's law against rubber's, and of what the modes
// leave out.
constexpr double kLawError = 0.08;
constexpr double kStretched = 1.5;  // deflection in thicknesses beyond which stretching rules
constexpr double kGoodFit = 1.5;    // residual at which no other start is tried
constexpr double kPoorFit = 3;      // residual
constexpr std::array kStarts = {0.1, 1.0, 10.0, 100.0};  // tensions where the search begins

void Require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

void Check(const MembraneState& state, double radius) {
  const std::size_t count = state.points_O.size();
  Require(count > 0 && state.heights.size() == count && state.sigmas.size() == count,
          "points, heights and sigmas of a state: accepted are equally many, one at least");
  Require(state.width >= 0 && state.p_O.norm() + state.width / 2 < radius,
          "a known load's place: accepted is inside the rim");
  Require(state.p_O.allFinite() && std::isfinite(state.force) && state.force_sigma >= 0 &&
              std::isfinite(state.force_sigma),
          "a known load: accepted are finite numbers, sigma >= 0");
  for (std::size_t i = 0; i < count; ++i) {
    Require(state.points_O[i].norm() <= radius * (1 + 1e-9), "a point is off the membrane");
    Require(std::isfinite(state.heights[i]), "a height is not finite");
    Require(state.sigmas[i] > 0 && std::isfinite(state.sigmas[i]),
            "a sigma: accepted is finite and > 0");
  }
}

// Unknowns in their natural units: tension, pressure, logarithm of the modulus by its start.
class Problem {
 public:
  Problem(const PlateLargeModel::Params& plate, std::span<const MembraneState> states,
          const MembraneUnknowns& unknowns)
      : plate_(plate),
        states_(states),
        asked_{true, unknowns.pressure, unknowns.modulus},
        modes_(plate.order, plate.poisson_ratio, plate::Symmetry::kMirror) {
    const double a = plate.radius, t = plate.thickness, nu = plate.poisson_ratio;
    const double D = plate.young_modulus * t * t * t / (12 * (1 - nu * nu));
    tension_unit_ = 16 * D / (a * a);
    pressure_unit_ = 64 * D * t / (a * a * a * a);
    for (const MembraneState& state : states) count_ += static_cast<Index>(state.heights.size());
  }

  [[nodiscard]] int unknowns() const { return static_cast<int>(std::ranges::count(asked_, true)); }
  [[nodiscard]] Index count() const { return count_; }
  [[nodiscard]] double tension_unit() const { return tension_unit_; }
  [[nodiscard]] double Tension(const Vector3d& x) const { return tension_unit_ * x[0]; }
  [[nodiscard]] double Pressure(const Vector3d& x) const { return pressure_unit_ * x[1]; }
  [[nodiscard]] double Modulus(const Vector3d& x) const {
    return plate_.young_modulus * std::exp(x[2]);
  }
  [[nodiscard]] double UnitOf(int k, const Vector3d& x) const {
    return k == 0 ? tension_unit_ : k == 1 ? pressure_unit_ : Modulus(x);
  }
  [[nodiscard]] bool asked(int k) const { return asked_[static_cast<std::size_t>(k)]; }

  // (measured - fitted) / sigma. `pushed`: the state whose force is one sigma larger; -1: none.
  // False: the plate finds no answer.
  bool Misfit(const Vector3d& x, int pushed, VectorXd* misfit) const {
    const double E = Modulus(x), t = plate_.thickness, a = plate_.radius;
    const double nu = plate_.poisson_ratio;
    const double tension = std::max(0.0, Tension(x)) * a * a / (E * t * t * t);
    const double force_unit = E * t * t * t * t / (a * a);
    plate::ModalPlate modal(modes_, 1 / (12 * (1 - nu * nu)), tension);
    misfit->resize(count_);
    Index row = 0;
    for (std::size_t s = 0; s < states_.size(); ++s) {
      const MembraneState& state = states_[s];
      const bool more = static_cast<int>(s) == pushed;
      // Along x from the centre to the load the plate is its own mirror image.
      const double r = state.p_O.norm();
      const Eigen::Vector2d axis = r > 0 ? Eigen::Vector2d(state.p_O / r) : Eigen::Vector2d(1, 0);
      const std::array presses = {
          ModalPlate::Press{.disc = {{0, 0}, 1}, .is_force = true},
          ModalPlate::Press{.disc = {{r / a, 0}, state.width / 2 / a}, .is_force = true}};
      const std::array values = {-Pressure(x) * std::numbers::pi * a * a / force_unit,
                                 -(state.force + (more ? state.force_sigma : 0)) / force_unit};
      modal.Place(presses, plate::Symmetry::kMirror);
      if (!modal.Solve(values)) return false;
      for (std::size_t i = 0; i < state.heights.size(); ++i, ++row) {
        const Eigen::Vector2d& p = state.points_O[i];
        const Eigen::Vector2d turned(axis.dot(p), axis.x() * p.y() - axis.y() * p.x());
        const double height = -t * modal.Deflection(turned / a);
        (*misfit)[row] = (state.heights[i] - height) / state.sigmas[i];
      }
    }
    return misfit->allFinite();
  }

 private:
  PlateLargeModel::Params plate_;
  std::span<const MembraneState> states_;
  std::array<bool, 3> asked_;
  double tension_unit_ = 0, pressure_unit_ = 0;
  Index count_ = 0;
  plate::PlateModes modes_;
};

struct Answer {
  Vector3d x{0, 0, 0};
  Eigen::Matrix<double, Eigen::Dynamic, 3> by;  // minus the misfit's derivatives
  VectorXd misfit;
};

bool Linearise(Problem& problem, Answer* answer) {
  VectorXd moved;
  answer->by.setZero(problem.count(), 3);
  for (int k = 0; k < 3; ++k) {
    if (!problem.asked(k)) continue;
    Vector3d x = answer->x;
    const double step = kDifference * std::max(1.0, std::abs(x[k]));
    x[k] += step;
    if (!problem.Misfit(x, -1, &moved)) return false;
    answer->by.col(k) = (answer->misfit - moved) / step;
  }
  return true;
}

Eigen::Matrix3d Normal(const Problem& problem, const Answer& answer) {
  Eigen::Matrix3d normal = answer.by.transpose() * answer.by;
  for (int k = 0; k < 3; ++k) {
    if (!problem.asked(k)) normal(k, k) = 1;
  }
  return normal;
}

// Levenberg's and Marquardt's method; tensions stay at or above zero.
bool Descend(Problem& problem, Answer* answer) {
  if (!problem.Misfit(answer->x, -1, &answer->misfit)) return false;
  double damping = 1e-3;
  VectorXd tried;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (!Linearise(problem, answer)) return false;
    const Eigen::Matrix3d normal = Normal(problem, *answer);
    const Vector3d slope = answer->by.transpose() * answer->misfit;
    bool better = false;
    Vector3d step = Vector3d::Zero();
    while (!better && damping < 1e8) {
      Eigen::Matrix3d damped = normal;
      damped.diagonal() *= 1 + damping;
      Vector3d next = answer->x + damped.ldlt().solve(slope);
      next[0] = std::max(0.0, next[0]);
      step = next - answer->x;
      better = next.allFinite() && problem.Misfit(next, -1, &tried) &&
               tried.squaredNorm() <= answer->misfit.squaredNorm();
      damping = better ? std::max(1e-9, damping / 10) : damping * 10;
      if (better) answer->x = next;
    }
    if (!better) break;  // at the bottom as far as rounding lets one see
    answer->misfit.swap(tried);
    if (step.dot(normal * step) <= kConverged * kConverged) break;
  }
  return Linearise(problem, answer);
}

// A start's pressure: what holds the largest height up by the bulge equation.
double BulgePressure(const PlateLargeModel::Params& plate, std::span<const MembraneState> states,
                     double tension) {
  double h = 0;
  for (const MembraneState& state : states) {
    for (const double height : state.heights) h = std::abs(height) > std::abs(h) ? height : h;
  }
  const double a = plate.radius;
  const double N = tension + 0.8 * plate.young_modulus * plate.thickness * h * h / (a * a);
  return 4 * N * h / (a * a);
}

// Errors of the known loads come on top of those of the points.
Eigen::Matrix3d Covariance(Problem& problem, const Answer& answer,
                           std::span<const MembraneState> states) {
  const Eigen::Matrix3d inverse = Normal(problem, answer).inverse();
  Eigen::Matrix3d covariance = inverse;
  VectorXd moved;
  for (std::size_t s = 0; s < states.size(); ++s) {
    if (!(states[s].force_sigma > 0)) continue;
    if (!problem.Misfit(answer.x, static_cast<int>(s), &moved)) continue;
    const Vector3d shift = inverse * (answer.by.transpose() * (moved - answer.misfit));
    covariance += shift * shift.transpose();
  }
  return covariance;
}

// Of the least deep of the known presses: the one that tells the tension [m].
double TellingDepth(std::span<const MembraneState> states) {
  double least = std::numeric_limits<double>::infinity();
  for (const MembraneState& state : states) {
    if (state.force == 0) continue;
    double depth = 0;
    for (const double height : state.heights) depth = std::max(depth, std::abs(height));
    least = std::min(least, depth);
  }
  return least;
}

std::string WhyNot(const Problem& problem, const MembraneIdentity& it, double depth,
                   double thickness) {
  if (it.residual > kPoorFit) {
    return "no tension explains the points: the load, its place or the material are others";
  }
  const double matters = std::max(it.prestress, problem.tension_unit());
  if (!(it.prestress_sigma < kKnown * matters)) {
    return depth > kStretched * thickness
               ? "the deflection is so large that stretching hides the tension at rest: press less"
               : "the deflection does not stand out of the noise enough to tell the tension at "
                 "rest: press harder, or take more pictures";
  }
  if (problem.asked(1) && !(it.pressure_sigma < kKnownShare * std::abs(it.pressure))) {
    return "the rest shape does not tell the pressure: it is flat within its noise";
  }
  if (problem.asked(2) && !(it.young_modulus_sigma < kKnownShare * it.young_modulus)) {
    return "the loads do not tell the modulus from the tension: take one below half the thickness "
           "and one beyond it";
  }
  return {};
}

}  // namespace

MembraneIdentity IdentifyMembrane(const PlateLargeModel::Params& plate,
                                  std::span<const MembraneState> states,
                                  const MembraneUnknowns& unknowns) {
  plate::RequirePlate({plate.radius, plate.thickness}, plate.young_modulus, plate.poisson_ratio);
  for (const MembraneState& state : states) Check(state, plate.radius);
  Problem problem(plate, states, unknowns);
  MembraneIdentity it;
  const bool loaded = std::ranges::any_of(states, [](const auto& s) { return s.force != 0; });
  if (problem.count() <= problem.unknowns() || !loaded) {
    it.reason = "too few points, or no state with a known load";
    return it;
  }
  const auto freedom = static_cast<double>(problem.count() - problem.unknowns());
  std::optional<Answer> best;
  for (const double start : kStarts) {
    Answer answer;
    answer.x[0] = start;
    if (unknowns.pressure) {
      const double p = BulgePressure(plate, states, start * problem.tension_unit());
      answer.x[1] = p / problem.UnitOf(1, answer.x);
    }
    const bool found = Descend(problem, &answer);
    if (found && (!best || answer.misfit.squaredNorm() < best->misfit.squaredNorm())) best = answer;
    if (best && best->misfit.squaredNorm() < kGoodFit * kGoodFit * freedom) break;
  }
  if (!best) {
    it.reason = "the plate finds no equilibrium under these loads";
    return it;
  }
  it.residual = std::sqrt(best->misfit.squaredNorm() / freedom);
  const Eigen::Matrix3d covariance = Covariance(problem, *best, states);
  const auto sigma = [&](int k) {
    return problem.asked(k) ? problem.UnitOf(k, best->x) * std::sqrt(covariance(k, k)) : 0;
  };
  it.prestress = problem.Tension(best->x);
  const double depth = TellingDepth(states);
  const double share = depth / plate.radius;
  const double stretch = problem.Modulus(best->x) * plate.thickness * share * share;
  it.prestress_sigma = std::hypot(sigma(0), kLawError * stretch);
  it.pressure = problem.Pressure(best->x);
  it.pressure_sigma = sigma(1);
  it.young_modulus = problem.Modulus(best->x);
  it.young_modulus_sigma = sigma(2);
  it.reason = WhyNot(problem, it, depth, plate.thickness);
  it.identified = it.reason.empty();
  return it;
}

}  // namespace palpate

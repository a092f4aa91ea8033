#include "slave/mechanics/plate/fit/load_fit.h"

#include <cmath>
#include <new>
#include <sstream>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "shared/text/text.h"
#include "slave/mechanics/plate/plate_law.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr int kMaxFitSteps = 40;
// Step of the difference quotients: radii, fraction of the force.
constexpr double kDifference = 1e-4;
constexpr double kConvergedFit = 1e-3;  // step relative to its standard deviation
// Radii, fraction of the force: smaller steps reuse the derivatives.
constexpr double kSmallStep = 0.02;
constexpr double kDamping = 1e-3, kMaxDamping = 1e8;
constexpr double kGoodFit = 3;       // residual that a start from the last answer must reach
constexpr double kInwards = 0.6;     // position of a second start relative to the first
constexpr double kSignificant = 25;  // misfit that the load must explain: five sigma squared
constexpr double kTrusted = 0.7;  // a smaller residual shows that the stated sigmas are too large
constexpr int kMinFreedom = 10;   // smallest number of degrees of freedom for this conclusion
// Smallest residual relative to sigma, because sigmas may be too large.
constexpr double kMinResidual = 0.1;
// Relative to kSignificant: limit for a fit with the small-deflection shape only.
constexpr double kBarely = 0.5;
constexpr double kFaint = 4;  // times kSignificant: below it the position may be undetermined
constexpr double kFaintInside = 0.7;  // radius within which such a load is assumed [radii]
constexpr double kVague = 0.25;       // standard deviation of an unknown position [radii]
constexpr std::string_view kNothing = "no load exceeds the noise";
constexpr int kFineSteps = 3;
constexpr double kFineConverged = 0.05;  // step relative to its standard deviation
constexpr double kAsWell = 1.1;          // accepted ratio to the previous squared misfit
constexpr double kOwnShape = 1e-6;  // smallest part of a change's squares that no load explains
constexpr double kRim = 1e-3;       // distance at which a load counts as at the rim [radii]
// Limit for a rigid face: its force rises without limit at the rim, and its domain ends before it.
constexpr double kRigidRim = 0.05;

// Returns the factor by which the stated sigmas are too large: the residual, if it is below one
// with enough points.
double SigmaScale(double residual, int freedom) {
  if (freedom < kMinFreedom) return 1;
  return std::clamp(residual / kTrusted, kMinResidual / kTrusted, 1.0);
}

// Returns the place, or the nearest one at a distance of `margin` from the centre [radii].
Vector2d Inside(const Vector2d& place, double margin) {
  const double r = place.norm();
  return r > margin ? Vector2d(place * (margin / r)) : place;
}

}  // namespace

LoadFitter::LoadFitter(PlateSurface& plate, const PlateSurface::Tool& tool, PlateSurface* finer)
    : plate_(plate),
      finer_(finer),
      asked_(&plate),
      tool_(tool),
      margin_(1 - (tool.is_rigid ? kRigidRim : kRim) - tool.width / 2 / plate.radius()),
      search_(tool.width / 2 / plate.radius(), margin_) {
  if (tool.width >= 0 && tool.width < 1.8 * plate.radius()) return;
  std::ostringstream accepted;
  accepted << "0 <= width < " << 1.8 * plate.radius();
  RefuseValue("width", tool.width, accepted.str());
}

LoadFit LoadFitter::Fit(std::span<const Vector2d> p_O, std::span<const double> displacement,
                        std::span<const double> sigma, Rim rim) noexcept {
  LoadFit fit;
  asked_ = &plate_;
  if (rim != rim_) last_.reset();
  rim_ = rim;
  try {
    fit.reason = Read(p_O, displacement, sigma);
  } catch (const std::bad_alloc&) {
    fit.reason = "out of memory";
  }
  if (!fit.reason.empty()) return fit;
  const plate::LoadSearch::Found seek =
      search_.Best(values_, weights_, rim_ == Rim::kStays ? nullptr : &rims_.columns(), 1);
  const double unexplained = std::max(0.0, values_.squaredNorm() - seek.explained);
  fit.residual = std::sqrt(unexplained / Freedom());
  const double sigma_scale = SigmaScale(fit.residual, Freedom());
  fit.nothing = seek.explained < kBarely * kSignificant * sigma_scale * sigma_scale;
  if (fit.nothing) {
    last_.reset();
    fit.reason = kNothing;
    fit.rim_motion = seen_rim_motion_;
    return fit;
  }
  Guess guess = last_.value_or(Guess{});
  bool found = last_ && Descend(&guess, &fit) && fit.residual <= kGoodFit;
  if (!found) found = HoldAt(seek, &guess) && DescendTwice(&guess, &fit);
  const Guess coarse = guess;
  const bool refined =
      !found || finer_ == nullptr || !AsksForMoreModes(guess) || Refine(&guess, &fit);
  found = found && pressed_ != Validity::kFailed;
  if (found) FillResult(guess, &fit);
  if (!refined && fit.validity == Validity::kValid) {
    fit.validity = Validity::kExtrapolated;
    fit.reason = "the plate with more modes does not find the load";
  }
  const bool known = found && fit.validity != Validity::kFailed;
  last_ = known ? std::optional(coarse) : std::nullopt;
  const bool faint = seek.explained < kFaint * kSignificant * sigma_scale * sigma_scale;
  const bool placed = known && !(faint && guess.place.norm() > kFaintInside);
  if (placed || fit.nothing) return fit;
  if (faint && FitFaint(&fit)) return fit;
  if (!found) {
    fit = {};
    fit.reason = "no load explains the points";
  }
  return fit;
}

LoadFit LoadFitter::FitCoarsely(std::span<const Vector2d> p_O, std::span<const double> displacement,
                                std::span<const double> sigma, Rim rim) noexcept {
  PlateSurface* const finer = std::exchange(finer_, nullptr);
  const LoadFit fit = Fit(p_O, displacement, sigma, rim);
  finer_ = finer;
  return fit;
}

bool LoadFitter::FitFaint(LoadFit* fit) noexcept {
  asked_ = &plate_;
  const plate::LoadSearch::Found seek = search_.Best(
      values_, weights_, rim_ == Rim::kStays ? nullptr : &rims_.columns(), kFaintInside);
  Guess guess;
  if (!HoldAt(seek, &guess) || !Press(guess)) return false;
  const double a = plate_.radius(), place = kVague * a, force = guess.force;
  *fit = {};
  fit->p_O = a * guess.place;
  fit->force = force;
  fit->covariance.diagonal() << place * place, place * place, force * force / seek.explained;
  fit->residual = std::sqrt(std::max(0.0, values_.squaredNorm() - seek.explained) / Freedom());
  fit->validity = Validity::kExtrapolated;
  fit->reason = "the load is too small for the points to determine its position";
  return true;
}

std::string_view LoadFitter::Read(std::span<const Vector2d> p_O,
                                  std::span<const double> displacement,
                                  std::span<const double> sigma) {
  if (p_O.size() != displacement.size() || p_O.size() != sigma.size()) {
    return "points, displacements and sigmas differ in number";
  }
  count_ = 0;
  measured_.resize(p_O.size());
  const auto count = static_cast<Index>(p_O.size());
  misfit_.resize(count);
  tried_.resize(count);
  shape_.resize(count);
  by_.resize(count, 3);
  values_.resize(count);
  weights_.resize(count);
  places_.resize(p_O.size());
  for (std::size_t i = 0; i < p_O.size(); ++i) {
    measured_[i] = {p_O[i] / plate_.radius(), displacement[i], sigma[i]};
    if (!(measured_[i].place.norm() <= 1 + 1e-9)) return "a point is off the plate or not finite";
    if (!std::isfinite(displacement[i])) return "a displacement is not finite";
    if (!(sigma[i] > 0)) return "a sigma is not > 0";
    if (std::isfinite(sigma[i])) ++count_;
    places_[i] = measured_[i].place;
    values_[static_cast<Index>(i)] = displacement[i] / sigma[i];
    weights_[static_cast<Index>(i)] = 1 / sigma[i];
  }
  if (count_ < 4) return "fewer than four points";
  if (rim_ == Rim::kMayMove && count_ < 7) return "fewer than seven points";
  rims_.Span(places_, sigma);
  seen_rim_motion_ = rims_.In(values_);
  if (rim_ == Rim::kMayMove) rims_.LeaveOut(&values_);
  search_.SetPoints(places_);
  return {};
}

// Computes the force that holds the plate at this position and deflection.
bool LoadFitter::HoldAt(const plate::LoadSearch::Found& found, Guess* guess) noexcept {
  const Contact held = PlateSurface::ToolContact(
      Contact::Kind::kDisplacement, plate_.radius() * found.place, tool_, found.deflection);
  plate_.Solve({&held, 1}, &solution_);
  const ContactResponse& response = solution_.responses().front();
  *guess = {found.place, response.force_O.z()};
  return response.validity != Validity::kFailed && guess->force != 0;
}

bool LoadFitter::Press(const Guess& guess) noexcept {
  allowed_ -= asked_ == finer_ ? kFinerCost : 1;
  pressed_ = Validity::kFailed;
  if (allowed_ < 0) return false;
  const Vector2d p_O = plate_.radius() * guess.place;
  const Contact load = PlateSurface::ToolContact(Contact::Kind::kForce, p_O, tool_, guess.force);
  asked_->Solve({&load, 1}, &solution_);
  pressed_ = solution_.responses().front().validity;
  return pressed_ != Validity::kFailed;
}

// Computes the misfit of the plate in its present state, with the motion of the rim.
void LoadFitter::Compare(Eigen::VectorXd* misfit) noexcept {
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const Measured& m = measured_[i];
    const bool counts = std::isfinite(m.sigma);
    const double fitted = counts ? asked_->Displacement(solution_, plate_.radius() * m.place) : 0;
    (*misfit)[static_cast<Index>(i)] = (m.value - fitted) / m.sigma;
  }
}

bool LoadFitter::Misfit(const Guess& guess, Eigen::VectorXd* misfit) noexcept {
  if (!Press(guess)) return false;
  Compare(misfit);
  if (rim_ == Rim::kMayMove) rims_.LeaveOut(misfit);
  return true;
}

// Computes derivatives by differences, with steps inwards to stay on the plate.
bool LoadFitter::Linearise(const Guess& guess) noexcept {
  force_unit_ = std::abs(guess.force);
  for (int k = 0; k < 3; ++k) {
    Guess moved = guess;
    double step = kDifference;
    if (k < 2) {
      if (guess.place[k] > 0) step = -step;
      moved.place[k] += step;
    } else {
      moved.force += step * force_unit_;
    }
    if (!Misfit(moved, &shape_)) return false;
    by_.col(k) = (misfit_ - shape_) / step;
  }
  return true;
}

// The shape of a stretched plate is blunter than the one in the search, so a load may seem nearer
// to the rim than it is. If the fit from there is not sufficient, it is repeated from a position
// further inside.
bool LoadFitter::DescendTwice(Guess* guess, LoadFit* fit) noexcept {
  Guess inner{kInwards * guess->place, guess->force};
  LoadFit inner_fit;
  const bool found = Descend(guess, fit);
  if (found && fit->residual <= kGoodFit) return true;
  const bool better = Descend(&inner, &inner_fit) && (!found || inner_fit.residual < fit->residual);
  if (better) {
    *guess = inner;
    *fit = inner_fit;
    return true;
  }
  return found && Descend(guess, fit);
}

// Derivatives need three solutions of the plate and a step only one, so small steps reuse the
// derivatives.
bool LoadFitter::Descend(Guess* guess, LoadFit* fit) noexcept {
  if (!Misfit(*guess, &misfit_)) return false;
  double damping = kDamping;
  bool share = false, pressed = true;  // state of the guess
  for (int iteration = 0; iteration < kMaxFitSteps; ++iteration) {
    if (guess->force == 0) return false;
    if (!share) {
      if (!Linearise(*guess)) return false;
      pressed = false;
    }
    const Eigen::Matrix3d normal = by_.transpose() * by_;
    const Eigen::Vector3d whole = normal.ldlt().solve(by_.transpose() * misfit_);
    if (whole.dot(normal * whole) <= kConvergedFit * kConvergedFit) break;
    const Guess last = *guess;
    pressed = Step(normal, &damping, guess);
    if (!pressed) {
      if (!share) break;  // at the minimum within rounding
      share = false;
      damping = kDamping;
      continue;
    }
    const Vector2d moved = guess->place - last.place;
    const Eigen::Vector3d taken(moved.x(), moved.y(), (guess->force - last.force) / force_unit_);
    if (taken.dot(normal * taken) <= kConvergedFit * kConvergedFit) break;
    share = moved.norm() < kSmallStep && std::abs(taken[2]) < kSmallStep;
  }
  fit->residual = std::sqrt(misfit_.squaredNorm() / Freedom());
  return pressed || Press(*guess);
}

// Returns true if the misfit decreased; the plate then has the new state.
bool LoadFitter::Step(const Eigen::Matrix3d& normal, double* damping, Guess* guess) noexcept {
  const Eigen::Vector3d slope = by_.transpose() * misfit_;
  for (; *damping < kMaxDamping; *damping *= 10) {
    Eigen::Matrix3d damped = normal;
    damped.diagonal() *= 1 + *damping;
    const Eigen::Vector3d step = damped.ldlt().solve(slope);
    const Guess next{Inside(guess->place + step.head<2>(), margin_),
                     guess->force + step[2] * force_unit_};
    if (!step.allFinite() || !Misfit(next, &tried_) ||
        tried_.squaredNorm() > misfit_.squaredNorm()) {
      continue;
    }
    *damping = std::max(1e-9, *damping / 10);
    misfit_.swap(tried_);
    *guess = next;
    return true;
  }
  return false;
}

// Returns whether the plate at the guess needs more modes.
bool LoadFitter::AsksForMoreModes(const Guess& guess) noexcept {
  const double w = std::abs(plate_.Displacement(solution_, plate_.radius() * guess.place));
  return w > plate_.thickness() * plate::ResolvedDeflection(guess.place.norm());
}

// Uses the Gauss-Newton method with the derivatives of the coarse plate. They differ from those of
// the fine plate by several percent, and so does the remaining error of each step. If this fails,
// it uses the fine plate's derivatives. False: the guess is unchanged, of the coarse plate;
// pressed_ states whether its solution is still present.
bool LoadFitter::Refine(Guess* guess, LoadFit* fit) noexcept {
  const Eigen::Matrix3d normal = by_.transpose() * by_;
  const Eigen::LDLT<Eigen::Matrix3d> factor(normal);
  Guess fine = *guess;
  asked_ = finer_;
  bool pressed = Misfit(fine, &misfit_);
  const double before = misfit_.squaredNorm();
  for (int taken = 0; pressed && taken < kFineSteps; ++taken) {
    const Eigen::Vector3d step = factor.solve(by_.transpose() * misfit_);
    if (step.dot(normal * step) <= kFineConverged * kFineConverged) break;
    fine.place = Inside(fine.place + step.head<2>(), margin_);
    fine.force += step[2] * force_unit_;
    pressed = step.allFinite() && Misfit(fine, &misfit_);
  }
  bool better = pressed && misfit_.squaredNorm() <= kAsWell * before + 1;
  if (!better) {  // happens near the centre, where the derivatives jump
    fine = *guess;
    better = Descend(&fine, fit);
  }
  if (better) {
    *guess = fine;
  } else {
    asked_ = &plate_;
    if (Misfit(*guess, &misfit_) && Linearise(*guess)) Press(*guess);
  }
  fit->residual = std::sqrt(misfit_.squaredNorm() / Freedom());
  return better;
}

// Uses least squares in position and magnitude of the load, linearised at the solution.
LoadFitter::Sought LoadFitter::Seek(std::span<const double> change) noexcept {
  if (!last_ || static_cast<Index>(change.size()) != shape_.size()) return {};
  for (std::size_t i = 0; i < change.size(); ++i) {
    shape_[static_cast<Index>(i)] = change[i] * weights_[static_cast<Index>(i)];
  }
  if (rim_ == Rim::kMayMove) rims_.LeaveOut(&shape_);
  const Eigen::Matrix3d normal = by_.transpose() * by_;
  const Eigen::Vector3d load = normal.ldlt().solve(by_.transpose() * shape_);
  const double all = shape_.squaredNorm();
  shape_.noalias() -= by_ * load;
  const double own = shape_.squaredNorm();
  if (!(own > kOwnShape * all) || !load.allFinite()) return {};
  return {shape_.dot(misfit_) / own, 1 / std::sqrt(own), -load[2] * force_unit_};
}

// Fits the rim's motion to the residuals of the plate in its present state.
Eigen::Vector3d LoadFitter::RimMotion() noexcept {
  if (rim_ == Rim::kStays) return rims_.In(misfit_);
  Compare(&shape_);
  return rims_.In(shape_);
}

void LoadFitter::FillResult(const Guess& guess, LoadFit* fit) noexcept {
  const double a = plate_.radius();
  const double explained = values_.squaredNorm() - misfit_.squaredNorm();
  const double sigma_scale = SigmaScale(fit->residual, Freedom());
  const Eigen::Matrix3d normal = by_.transpose() * by_;
  const Eigen::Vector3d unit(a, a, force_unit_);
  fit->p_O = a * guess.place;
  fit->force = guess.force;
  fit->covariance = unit.asDiagonal() * normal.inverse() * unit.asDiagonal();
  const double vague = sigma_scale * std::sqrt(fit->covariance.topLeftCorner<2, 2>().trace()) / a;
  fit->rim_motion = RimMotion();
  if (explained < kSignificant * sigma_scale * sigma_scale) {
    fit->nothing = true;
    fit->reason = kNothing;
  } else if (guess.place.norm() > margin_ - kRim) {
    fit->reason = "the load lies at the rim or beyond";
  } else if (!(vague < kVague)) {
    fit->reason = "the points do not determine the load's position";
  } else {
    const bool fits = fit->residual <= kGoodFit;
    fit->validity = fits ? pressed_ : Worse(pressed_, Validity::kExtrapolated);
    if (!fits)
      fit->reason = "the residual of one load of this width exceeds the noise of the points";
  }
}

}  // namespace palpate

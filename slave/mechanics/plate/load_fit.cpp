#include "slave/mechanics/plate/load_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "slave/mechanics/plate/green.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr int kIterations = 40;
constexpr int kRings = 5;               // of places that are tried
constexpr double kDifference = 1e-4;    // of the derivatives: radii, share of the force
constexpr double kConverged = 1e-4;     // step by its standard deviation
constexpr double kGoodFit = 3;          // residual that a start from the last answer must reach
constexpr double kInwards = 0.6;        // of a second start
constexpr double kStandsOut = 25;       // misfit that the load must explain: five sigma squared
constexpr double kTrusted = 0.7;        // a residual below it says that the sigmas are too large
constexpr double kLeastResidual = 0.1;  // by which sigmas may be too large
constexpr double kVague = 0.25;         // standard deviation of a place not known [radii]
constexpr double kNoDirection = 1e-6;   // share of a rim's motion that others do not explain
constexpr double kRim = 1e-3;           // nearer than that a load is at the rim [radii]

}  // namespace

LoadFitter::LoadFitter(PlateSurface& plate, double width)
    : plate_(plate), width_(width), margin_(1 - kRim - width / 2 / plate.radius()) {
  if (width >= 0 && width < 1.8 * plate.radius()) return;
  std::ostringstream text;
  text << "width = " << width << ": accepted is 0 <= width < " << 1.8 * plate.radius();
  throw std::invalid_argument(text.str());
}

LoadFit LoadFitter::Fit(std::span<const Vector2d> p_O, std::span<const double> displacement,
                        std::span<const double> sigma, Rim rim) noexcept {
  LoadFit fit;
  if (rim != rim_) known_ = false;
  rim_ = rim;
  try {
    fit.reason = Read(p_O, displacement, sigma);
  } catch (const std::bad_alloc&) {
    fit.reason = "out of memory";
  }
  if (!fit.reason.empty()) return fit;
  Guess guess = last_;
  bool found = known_ && Descend(&guess, &fit) && fit.residual <= kGoodFit;
  if (!found) found = Search(&guess) && DescendTwice(&guess, &fit);
  known_ = false;
  if (!found) {
    fit = {};
    double nothing = 0;
    for (const Measured& m : measured_) nothing += (m.value / m.sigma) * (m.value / m.sigma);
    fit.nothing = nothing < kStandsOut;
    fit.reason = fit.nothing ? "no load stands out of the noise" : "no load explains the points";
    return fit;
  }
  Judge(guess, &fit);
  known_ = fit.validity != Validity::kFailed;
  last_ = guess;
  return fit;
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
  for (std::size_t i = 0; i < p_O.size(); ++i) {
    measured_[i] = {p_O[i] / plate_.radius(), displacement[i], sigma[i]};
    if (!(measured_[i].place.norm() <= 1 + 1e-9)) return "a point is off the plate or not finite";
    if (!std::isfinite(displacement[i])) return "a displacement is not finite";
    if (!(sigma[i] > 0)) return "a sigma is not > 0";
    if (std::isfinite(sigma[i])) ++count_;
  }
  if (count_ < 4) return "fewer than four points";
  if (rim_ == Rim::kMayMove && count_ < 7) return "fewer than seven points";
  SpanRimMotion();
  return {};
}

// By Gram and Schmidt. Motions that the points cannot tell apart are left out.
void LoadFitter::SpanRimMotion() {
  rim_motions_.resize(misfit_.size(), 3);
  for (Index i = 0; i < misfit_.size(); ++i) {
    const Measured& m = measured_[static_cast<std::size_t>(i)];
    rim_motions_.row(i) << 1 / m.sigma, m.place.x() / m.sigma, m.place.y() / m.sigma;
  }
  rim_values_.setIdentity();
  for (int k = 0; k < 3; ++k) {
    const double size = rim_motions_.col(k).norm();
    for (int j = 0; j < k; ++j) {
      const double share = rim_motions_.col(j).dot(rim_motions_.col(k));
      rim_motions_.col(k) -= share * rim_motions_.col(j);
      rim_values_.col(k) -= share * rim_values_.col(j);
    }
    const double left = rim_motions_.col(k).norm();
    const double scale = left > kNoDirection * size ? 1 / left : 0;
    rim_motions_.col(k) *= scale;
    rim_values_.col(k) *= scale;
  }
}

void LoadFitter::LeaveOutRimMotion(Eigen::VectorXd* values) const noexcept {
  if (rim_ == Rim::kStays) return;
  for (int k = 0; k < 3; ++k) *values -= rim_motions_.col(k).dot(*values) * rim_motions_.col(k);
}

// The place whose small-deflection shape, at its best size, leaves the least; the force is what
// holds the plate there at that deflection.
bool LoadFitter::Search(Guess* best) noexcept {
  double most = 0;
  double deflection = 0;
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    misfit_[static_cast<Index>(i)] = measured_[i].value / measured_[i].sigma;
  }
  LeaveOutRimMotion(&misfit_);
  const auto consider = [&](const Vector2d& place) {
    const plate::Disc disc{place, width_ / 2 / plate_.radius()};
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      const Measured& m = measured_[i];
      shape_[static_cast<Index>(i)] = plate::Deflection(disc, m.place) / m.sigma;
    }
    LeaveOutRimMotion(&shape_);
    const double mixed = shape_.dot(misfit_), square = shape_.squaredNorm();
    if (!(mixed * mixed > most * square)) return;
    most = mixed * mixed / square;
    best->place = place;
    deflection = mixed / square * plate::Deflection(disc, place);
  };
  consider({0, 0});
  for (int ring = 1; ring <= kRings; ++ring) {
    const double r = margin_ * (ring - 0.1) / kRings;
    for (int i = 0; i < 6 * ring; ++i) {
      const double angle = std::numbers::pi * i / (3 * ring);
      consider({r * std::cos(angle), r * std::sin(angle)});
    }
  }
  Contact contact;
  contact.p_O.head<2>() = plate_.radius() * best->place;
  contact.width = width_;
  contact.value_O.z() = deflection;
  ContactResponse response;
  plate_.Respond(std::span(&contact, 1), std::span(&response, 1));
  best->force = response.force_O.z();
  return response.validity != Validity::kFailed && best->force != 0;
}

Vector2d LoadFitter::Inside(const Vector2d& place) const noexcept {
  const double r = place.norm();
  return r > margin_ ? Vector2d(place * (margin_ / r)) : place;
}

bool LoadFitter::Press(const Guess& guess) noexcept {
  Contact contact;
  contact.kind = Contact::Kind::kForce;
  contact.p_O.head<2>() = plate_.radius() * guess.place;
  contact.width = width_;
  contact.value_O.z() = guess.force;
  ContactResponse response;
  plate_.Respond(std::span(&contact, 1), std::span(&response, 1));
  pressed_ = response.validity;
  return pressed_ != Validity::kFailed;
}

bool LoadFitter::Misfit(const Guess& guess, Eigen::VectorXd* misfit) noexcept {
  if (!Press(guess)) return false;
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const Measured& m = measured_[i];
    const bool counts = std::isfinite(m.sigma);
    const double fitted = counts ? plate_.Displacement(plate_.radius() * m.place) : 0;
    (*misfit)[static_cast<Index>(i)] = (m.value - fitted) / m.sigma;
  }
  LeaveOutRimMotion(misfit);
  return true;
}

// Derivatives by differences, inwards so as to stay on the plate.
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

// A stretched plate is blunter than the shape that was searched with, so that a load may seem
// nearer to the rim than it is: what is not explained from there is tried from further inside.
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

bool LoadFitter::Descend(Guess* guess, LoadFit* fit) noexcept {
  if (!Misfit(*guess, &misfit_)) return false;
  double damping = 1e-3;
  bool converged = false;
  for (int iteration = 0; iteration < kIterations && !converged; ++iteration) {
    if (guess->force == 0 || !Linearise(*guess)) return false;
    const Eigen::Matrix3d normal = by_.transpose() * by_;
    const Eigen::Vector3d slope = by_.transpose() * misfit_;
    bool better = false;
    while (!better && damping < 1e8) {
      Eigen::Matrix3d damped = normal;
      damped.diagonal() *= 1 + damping;
      const Eigen::Vector3d step = damped.ldlt().solve(slope);
      const Guess next{Inside(guess->place + step.head<2>()), guess->force + step[2] * force_unit_};
      better = step.allFinite() && Misfit(next, &tried_) &&
               tried_.squaredNorm() <= misfit_.squaredNorm();
      damping = better ? std::max(1e-9, damping / 10) : damping * 10;
      if (!better) continue;
      const Eigen::Vector3d taken(next.place.x() - guess->place.x(),
                                  next.place.y() - guess->place.y(),
                                  (next.force - guess->force) / force_unit_);
      converged = taken.dot(normal * taken) <= kConverged * kConverged;
      misfit_.swap(tried_);
      *guess = next;
    }
    if (!better) break;  // at the bottom as far as rounding lets one see
  }
  const int freedom = std::max(1, count_ - (rim_ == Rim::kStays ? 3 : 6));
  fit->residual = std::sqrt(misfit_.squaredNorm() / freedom);
  return Linearise(*guess) && Press(*guess);
}

// By the residuals of the plate as it is pressed now.
Eigen::Vector3d LoadFitter::RimMotion() noexcept {
  if (rim_ == Rim::kStays) return rim_values_ * (rim_motions_.transpose() * misfit_);
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const Measured& m = measured_[i];
    const double fitted = plate_.Displacement(plate_.radius() * m.place);
    shape_[static_cast<Index>(i)] = (m.value - fitted) / m.sigma;
  }
  return rim_values_ * (rim_motions_.transpose() * shape_);
}

void LoadFitter::Judge(const Guess& guess, LoadFit* fit) noexcept {
  const double a = plate_.radius();
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    shape_[static_cast<Index>(i)] = measured_[i].value / measured_[i].sigma;
  }
  LeaveOutRimMotion(&shape_);
  const double explained = shape_.squaredNorm() - misfit_.squaredNorm();
  const double doubt = std::clamp(fit->residual / kTrusted, kLeastResidual / kTrusted, 1.0);
  const Eigen::Matrix3d normal = by_.transpose() * by_;
  const Eigen::Vector3d unit(a, a, force_unit_);
  fit->p_O = a * guess.place;
  fit->force = guess.force;
  fit->covariance = unit.asDiagonal() * normal.inverse() * unit.asDiagonal();
  const double vague = std::sqrt(fit->covariance.topLeftCorner<2, 2>().trace()) / a;
  fit->rim_motion = RimMotion();
  if (explained < kStandsOut * doubt * doubt) {
    fit->nothing = true;
    fit->reason = "no load stands out of the noise";
  } else if (guess.place.norm() > margin_ - kRim) {
    fit->reason = "the load lies at the rim or beyond";
  } else if (!(vague < kVague)) {
    fit->reason = "the points do not determine the load's place";
  } else {
    const bool fits = fit->residual <= kGoodFit;
    fit->validity = fits ? pressed_ : Worse(pressed_, Validity::kExtrapolated);
    if (!fits) fit->reason = "one load of this width leaves more than the points' noise";
  }
}

}  // namespace palpate

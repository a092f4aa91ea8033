// How localisers answer.
#pragma once

#include "slave/tactile/localise/finger_surface.h"
#include "slave/tactile/localise/localiser.h"

namespace palpate {

inline TouchPlace NoPlace(TouchPlace::Status status, bool is_flawed = false) noexcept {
  TouchPlace place;
  place.status = status;
  place.is_flawed = is_flawed;
  return place;
}

// Without one electrode the median error is up to 1.6 times what it is with all (measured by
// leaving out each of them in turn).
inline constexpr double kFlawedSigma = 1.6;

// At `p_F` on the surface; `sigma_angle` [rad] is what it is about the sphere's centre or the axis.
inline TouchPlace FoundPlace(const FingerSurface& surface, const Eigen::Vector3d& p_F,
                             double sigma_angle, bool is_flawed, int active) noexcept {
  TouchPlace place;
  place.status = is_flawed ? TouchPlace::Status::kFlawed : TouchPlace::Status::kFound;
  place.p_F = p_F;
  place.n_F = surface.Normal(p_F);
  place.sigma = surface.radius * sigma_angle * (is_flawed ? kFlawedSigma : 1);
  place.active = active;
  place.is_flawed = is_flawed;
  return place;
}

}  // namespace palpate

// The contact as the master renders it between two states: one-sided, decided here and not by the
// slave's late word (Adachi et al. 1995; Mark et al. 1996).
//
//   f = f_r + K (x_r - p)   for n . (x_r - p) > 0,   else 0
//
// An f_r into the object, as of the tangent to a law that stiffens, never makes the contact pull.
//
// When the slave changes the plane or the stiffness, x_r, n, f_r and K go from their present to
// their new values in 30 ms, straight in time. The force follows the hand at once and both ways:
// a limit on its rise alone would make a limit cycle, as would dropping the plane on a late "no
// contact".
//
// Where along the plane x_r lies decides the shear. Until the slave tells of contact its x_r is
// only the nearest place, late by the way gone since; the contact then is where the hand came
// through the plane, as it will be for the slave, and nothing pulls sideways. Frame S.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "shared/state/local_model.h"

namespace palpate {

class LocalContact {
 public:
  static constexpr double kBlendTime = 0.030;  // [s]

  // Takes the slave's newest model at `now` [s]. Unknown ones (revision 0) leave the last in place.
  // The first one grows from no stiffness. Real-time safe.
  void Take(const LocalModel& model, double now) noexcept;
  // Moves the tip to `p_S`: force of the object on the tool there [N]. Zero while nothing is known.
  // Real-time safe.
  [[nodiscard]] Eigen::Vector3d ForceAt(const Eigen::Vector3d& p_S, double now) noexcept;
  // The tip is taken elsewhere: where it came through the plane counts no more. Real-time safe.
  void LetGo() noexcept { entry_.reset(); }
  // The model in force at `now`.
  [[nodiscard]] LocalModel At(double now) const noexcept;
  [[nodiscard]] bool known() const noexcept { return to_.known(); }
  [[nodiscard]] bool IsBlending(double now) const noexcept {
    return known() && now - since_ < kBlendTime;
  }
  // The tip is farther from the reference than the slave vouches for.
  [[nodiscard]] bool IsBeyond(const Eigen::Vector3d& p_S) const noexcept;

 private:
  LocalModel from_, to_;
  double since_ = 0;  // when the blend from `from_` to `to_` began [s]
  // Where the tip came through the plane, or what stood for it; nothing: it is outside.
  std::optional<Eigen::Vector3d> entry_;
};

// Finite, a normal of unit length within 1 %, and no number beyond 1e12: fit to be rendered.
bool IsSane(const LocalModel& model) noexcept;

}  // namespace palpate

// Contact of a fingertip with the object's mesh, and its load (paper B, III.B, equations 5 to 7).
#pragma once

#include <array>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/validity.h"
#include "shared/state/verdict.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"
#include "slave/tactile/fingertip.h"

namespace palpate {

// The contact point lies on the deformed surface, the model takes places at rest. The place is the
// closest one where contact begins, and moves along the surface with the contact point from then
// on, once that is 2 mm away: localising is good for no less, and a place that hops from sample to
// sample shakes the mesh. Taking off the model's displacement instead feeds the model's error back:
// on the narrow side of the foam sponge the place ran away.
//
// A touch must begin and end where the pose has it: a fingertip that is deep in the object and
// feels nothing, or feels something well off it, is not where its pose says, or feels late. Such a
// contact is flagged until it is over. A fingertip that is in the object while its baseline is
// measured is flagged until it is measured again.
//
// Holding by displacement takes the place's depth under the fingertip's surface from the pose, and
// lasts until the pose lets go: samples in which the contact is not felt change nothing.
class FingerContact {
 public:
  explicit FingerContact(const Tactile& tactile);

  // `X_OF`: where the fingertip is; forces beyond `largest_force` [N] do not act. Allocation-free.
  void Update(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
              const FingerTouch& touch, double largest_force) noexcept;
  // Nothing is known of where the fingertip is, or it touches nothing.
  void LetGo() noexcept;
  // The force of the fingertip acts instead of its displacement, if it is known.
  void ActByForce() noexcept;

  // There is something to act on the mesh: `contact()`.
  [[nodiscard]] bool acts() const { return acts_; }
  [[nodiscard]] const Contact& contact() const { return contact_; }
  // The contact point is known: `p_O`, at rest.
  [[nodiscard]] bool has_place() const { return has_place_; }
  [[nodiscard]] const Eigen::Vector3d& p_O() const { return contact_.p_O; }
  [[nodiscard]] const Eigen::Vector3d& n_O() const { return n_O_; }
  [[nodiscard]] const Eigen::Vector3d& weights() const { return weights_; }
  // kExtrapolated if pose and contact do not fit the object.
  [[nodiscard]] const Verdict& verdict() const { return verdict_; }

 private:
  bool FindPlace(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
                 const FingerTouch& touch) noexcept;
  void FindSurfaceContact(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
                          const FingerTouch& touch, double largest_force) noexcept;
  void CompareBeginning(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
                        const FingerTouch& touch) noexcept;
  void WatchRest(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
                 const FingerTouch& touch) noexcept;
  [[nodiscard]] double DepthAtPlace(const Eigen::Isometry3d& X_OF) const noexcept;
  void TakeForce(const Eigen::Isometry3d& X_OF, const FingerTouch& touch,
                 double largest_force) noexcept;

  double radius_, gate_;
  bool holds_;
  Contact contact_;  // p_O, element and width of the contact
  Eigen::Vector3d n_O_{0, 0, 0}, weights_{0, 0, 0};
  Eigen::Vector3d found_from_O_{0, 0, 0};  // the contact point for which it was found [m]
  Eigen::Vector3d force_O_{0, 0, 0};       // of the fingertip on the object [N]
  bool is_late_ = false;
  bool takes_rest_ = false, rested_pressed_ = false;  // now; when the baseline was last measured
  bool has_place_ = false, has_force_ = false, acts_ = false;
  Verdict verdict_{Validity::kValid};
};

// How deep the surface of a fingertip (sphere and cylinder of `radius`, frame F) lies under `p_O`,
// against the outward normal `n_O` [m]; negative: it does not reach it.
double DepthUnderFinger(const Eigen::Isometry3d& X_OF, double radius, const Eigen::Vector3d& p_O,
                        const Eigen::Vector3d& n_O) noexcept;

}  // namespace palpate

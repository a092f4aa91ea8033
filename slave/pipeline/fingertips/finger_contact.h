// Contact of a fingertip with the object's mesh, and its load (paper B, III.B, equations 5 to 7).
#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/contact/surface_contact.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/scene/scene.h"
#include "slave/tactile/fingertip.h"

namespace palpate {

// The contact point is on the deformed surface, but the model needs a place at rest. It is the
// closest place at the beginning of the contact. Later it moves along the surface with the contact
// point, in steps of at least 2 mm: localisation is not more accurate, and a place that jumps with
// each sample makes the mesh vibrate. Subtracting the model's displacement instead would feed back
// the model's error: on the narrow side of the foam sponge the place drifted away.
//
// With `hold: displacement` the depth of the place below the fingertip's surface follows from the
// pose, and the contact lasts until the pose ends it; samples without a measured contact change
// nothing.
//
// With friction the contact is a rigid tool: it stays at the place of its first touch, from where
// the pad's motion along the surface is prescribed too, until its depth is zero.
class FingerContact {
 public:
  explicit FingerContact(const Tactile& tactile);

  // What the object's model takes.
  struct Limits {
    double largest_force = 0;   // larger forces do not act [N]
    bool has_friction = false;  // the model follows the path of a contact along the surface
  };
  // `X_OF`: where the fingertip is. Allocation-free.
  void Update(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
              const FingerTouch& touch, const Limits& limits) noexcept;
  // Ends the contact, because the position of the fingertip is unknown or it touches nothing.
  void EndContact() noexcept;
  // Uses the force of the fingertip instead of its displacement, if it is known.
  void ActByForce() noexcept;

  // Returns whether `contact()` acts on the mesh.
  [[nodiscard]] bool acts() const { return acts_; }
  [[nodiscard]] const Contact& contact() const { return contact_; }
  // Returns whether the contact point at rest, place(), is known. With friction it is where the
  // fingertip is now, and contact() where it touched first.
  [[nodiscard]] bool has_place() const { return has_place_; }
  [[nodiscard]] const TouchedPlace& place() const { return place_; }
  // Why pose and contact do not fit the object, one clause with static lifetime; empty: they fit.
  [[nodiscard]] std::string_view misplaced() const { return misplaced_; }
  // Returns whether the force exceeds `largest_force`.
  [[nodiscard]] bool is_beyond_model() const { return is_beyond_model_; }

 private:
  // A contact with friction since its first touch.
  struct Slide {
    Eigen::Vector3d p_F{0, 0, 0};  // the pad's point that touched first [m]
    TouchedPlace from;             // where it touched
  };
  void KeepPlace(const Eigen::Isometry3d& X_OF, const FingerTouch& touch,
                 double largest_force) noexcept;
  bool FindPlace(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
                 const FingerTouch& touch) noexcept;
  // Depth of the contact, and the way along the surface since the first touch [m].
  [[nodiscard]] double DepthOf(const Eigen::Isometry3d& X_OF) const noexcept;
  [[nodiscard]] Eigen::Vector3d WayOf(const Eigen::Isometry3d& X_OF) const noexcept;
  void ActByDisplacement(const Eigen::Isometry3d& X_OF, double depth) noexcept;
  void TakeForce(const Eigen::Isometry3d& X_OF, const FingerTouch& touch,
                 double largest_force) noexcept;

  double radius_, gate_;
  bool holds_;
  Contact contact_;
  TouchedPlace place_;
  std::optional<Slide> slide_;             // nullopt: no friction, or no depth
  Eigen::Vector3d found_from_O_{0, 0, 0};  // the contact point for which it was found [m]
  Eigen::Vector3d force_O_{0, 0, 0};       // of the fingertip on the object [N]
  bool has_place_ = false, has_force_ = false, acts_ = false, is_beyond_model_ = false;
  std::string_view misplaced_;
};

// Returns the depth of the fingertip's sphere, or of the cylinder behind it, below the surface at
// rest [m].
double DepthBelow(const SurfaceContact& surface, const Eigen::Isometry3d& X_OF,
                  double radius) noexcept;

// Returns the depth of a fingertip's surface (sphere and cylinder of `radius`, frame F) below
// `p_O`, against the outward normal `n_O` [m]; negative: it does not reach it.
double DepthUnderFinger(const Eigen::Isometry3d& X_OF, double radius, const Eigen::Vector3d& p_O,
                        const Eigen::Vector3d& n_O) noexcept;

}  // namespace palpate

// The contact that the master renders by itself, for a fingertip: the plane it meets, before it
// touches too, and the object's stiffness there.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/scene/scene.h"
#include "shared/state/local_model.h"
#include "slave/pipeline/tactile_body.h"

namespace palpate {

// `next` as the successor of `last`: a revision of its own if something changed.
LocalModel Revised(LocalModel next, const LocalModel& last) noexcept;

// The plane is that in which the fingertip's sphere would meet the surface at rest. Its reference
// is where the moved tip, the pad's apex, lies when the sphere comes through: exact for every
// direction of approach. A bonded contact keeps its plane and place until the sphere has come out;
// a frictionless one follows the sphere until its centre comes inside.
class LocalTouch {
 public:
  explicit LocalTouch(const Scene& scene);

  // `model` becomes that of the fingertip at `X_SF`; it keeps its plane while the pose is not
  // finite.
  void Update(TactileBody& body, const Eigen::Isometry3d& X_SO, const Eigen::Isometry3d& X_SF,
              bool in_contact, LocalModel* model) noexcept;
  // Of the fingertip's sphere below the surface at rest [m]; negative outside.
  [[nodiscard]] double depth() const { return depth_; }
  // The place of the surface at rest, frame O [m].
  [[nodiscard]] const Eigen::Vector3d& p_O() const { return p_O_; }
  // The plane is looked for anew.
  void Forget() noexcept { triangle_ = -1; }

 private:
  void FindPlane(const TactileBody& body, const Eigen::Vector3d& p_O_centre) noexcept;
  [[nodiscard]] Eigen::Matrix3d StiffnessOf(TactileBody& body) noexcept;

  Material material_;
  ContactLaw law_;
  double radius_, disc_radius_, full_depth_;
  int triangle_ = -1;
  Eigen::Vector3d p_O_{0, 0, 0}, n_O_{0, 0, 0}, weights_{0, 0, 0};
  double depth_ = 0;
};

}  // namespace palpate

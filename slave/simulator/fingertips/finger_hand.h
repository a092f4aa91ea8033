// The fingers of a scene as rigid bodies that move together with the manipulator.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slave/scene/scene.h"
#include "slave/simulator/fingertips/pressed_body.h"

namespace palpate::simulation {

// A fingertip's outside as a rigid body: half sphere and cylinder behind it (paper B, equation 4),
// closed by another half sphere at the far end.
// Frame F.
struct RigidFinger {
  double radius = 7e-3;  // [m]
  double length = 0.02;  // of the cylinder, towards -x [m]

  // Signed distance of a point, < 0 inside [m].
  [[nodiscard]] double Distance(const Eigen::Vector3d& p_F) const noexcept;
  // Outward unit normal of the surface nearest to a point.
  [[nodiscard]] Eigen::Vector3d Normal(const Eigen::Vector3d& p_F) const noexcept;
  // Exit of an inner point from the finger if the finger arrived along `direction_F` (unit): it is
  // pushed ahead. Zero: the nearest point of the surface.
  [[nodiscard]] Eigen::Vector3d PushOut(const Eigen::Vector3d& p_F,
                                        const Eigen::Vector3d& direction_F) const noexcept;
};

// Frame O. The displacement from home is h_O; fingers never rotate.
struct FingerHand {
  struct OneFinger {
    Eigen::Isometry3d X_OF_home = Eigen::Isometry3d::Identity();
    double sense = 1;  // the finger moves by sense h_O: 1 in the same direction, -1 opposite, 0 not
  };
  std::vector<OneFinger> fingers;
  RigidFinger shape;
  Eigen::Vector3d approach_O{0, 0, -1};  // unit vector of the approach

  // The pose of finger `f`.
  [[nodiscard]] Eigen::Isometry3d PoseOf(std::size_t f, const Eigen::Vector3d& h_O) const;
  // All fingers after motion by `s` along the approach, with the offset `lateral_O`.
  [[nodiscard]] std::vector<FingerPlacement> Placements(const Eigen::Vector3d& lateral_O,
                                                        double s) const;
  // Returns the distance along the approach at which finger `f` touches the first of `nodes_O`;
  // infinity: it touches none. O(N).
  [[nodiscard]] double FirstTouch(std::size_t f, const Eigen::Vector3d& lateral_O,
                                  const std::vector<Eigen::Vector3d>& nodes_O) const;
};

FingerHand MakeFingerHand(const Tactile& tactile, const Eigen::Isometry3d& X_SO);

}  // namespace palpate::simulation

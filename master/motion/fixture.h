// Virtual fixtures: regions that the tool stays in, by a spring at the device.
//
//   f_M = K (1 - d_0 / d) R_SM^T (c(p_S) - p_S) / s_p,   d = |c(p_S) - p_S| > d_0;   else 0
//
// c: the nearest point of the region; s_p: position scale; K: stiffness at the device. d_0 is the
// smallest distance since the engagement: a tool that begins outside is not pulled in, but may not
// go farther out. Passive: the force is minus the gradient of U = K max(0, d - d_0)^2 / 2 s_p^2,
// which is zero at the engagement and whenever d_0 falls. Regions are convex, so the curvature of U
// is at most K, and for each step dp of the device
//
//   f . dp <= U(p) - U(p + dp) + K |dp|^2 / 2
//
// The last term is the energy created by holding the force for a tick T. The damping b of device
// and operator dissipates it if K <= 2 b / T (Colgate & Schenkel 1994). Virtual fixtures: Rosenberg
// 1993.
#pragma once

#include <string>
#include <string_view>

#include <Eigen/Core>

namespace palpate {

struct Fixture {
  enum class Kind {
    kPlane,   // the half space that `direction` points into from `point`
    kLine,    // within `size` [m] of the line through `point` along `direction`
    kSphere,  // within `size` [m] of `point`
    kCone,    // opens from its apex `point` along `direction`; `size`: half angle [rad]
    kBox,     // from the corner `point` to the corner `direction`
  };
  Kind kind = Kind::kPlane;
  Eigen::Vector3d point{0, 0, 0};      // S [m]
  Eigen::Vector3d direction{0, 0, 1};  // S, of unit length [-]; of a box: its upper corner [m]
  double size = 0;

  // `plane:X,Y,Z:NX,NY,NZ`, `line:X,Y,Z:DX,DY,DZ[:RADIUS]`, `sphere:X,Y,Z:RADIUS`, or
  // `cone:X,Y,Z:DX,DY,DZ:DEGREES`. Lengths in mm, frame S. Throws std::invalid_argument.
  static Fixture Parse(std::string_view text);
  // `X,Y,Z:X,Y,Z`: two opposite corners in mm. Throws std::invalid_argument.
  static Fixture ParseBox(std::string_view text);
  // The nearest point of the region [m]; `p_S` itself inside. Real-time safe.
  [[nodiscard]] Eigen::Vector3d Nearest(const Eigen::Vector3d& p_S) const noexcept;
};

// The distance beyond the region, as a vector towards it. One per fixture.
class FixtureSpring {
 public:
  explicit FixtureSpring(const Fixture& fixture) : fixture_(fixture) {}

  // Begins a new engagement at `p_S`. Real-time safe, like the next one.
  void Begin(const Eigen::Vector3d& p_S) noexcept;
  // (1 - d_0 / d) (c(p_S) - p_S) [m].
  [[nodiscard]] Eigen::Vector3d Pull(const Eigen::Vector3d& p_S) noexcept;

 private:
  Fixture fixture_;
  double free_ = 0;  // d_0 [m]
};

}  // namespace palpate

// The shape of a rigid tool: its surface near a body.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace palpate {

struct RigidTool {
  enum class Shape : std::uint8_t {
    kFlat,     // a disc across the surface normal at the contact, as wide as the contact
    kSphere,   // of `radius`
    kCapsule,  // a cylinder of `radius` along axis_O with half spheres at both ends
  };
  Shape shape = Shape::kFlat;
  double radius = 0;                // [m]
  double length = 0;                // of the cylinder [m]
  Eigen::Vector3d axis_O{1, 0, 0};  // its direction, unit
};

}  // namespace palpate

// The shape of a rigid tool: its surface near a body.
#pragma once

#include <cstdint>

namespace palpate {

struct RigidTool {
  enum class Shape : std::uint8_t {
    kFlat,    // a disc across the surface normal at the contact, as wide as the contact
    kSphere,  // of `radius`
  };
  Shape shape = Shape::kFlat;
  double radius = 0;  // [m]
};

}  // namespace palpate

// Detects implausible numbers by the ranges of typical objects, and suggests the unit that was
// probably intended.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

enum class Plausible : std::uint8_t {
  kYoungModulus,    // of a soft solid [Pa]
  kDensity,         // of a solid [kg/m^3]
  kGravity,         // [m/s^2]
  kBodySize,        // longest side of a body on a desk [m]
  kFingertipForce,  // force on a fingertip [N]
  kHandPosition,    // of a haptic device's tip, from its origin [m]
};

// `object.material.density = 1.07 kg/m3: expected 5 to 25000; in g/cm3 it would be 1070 kg/m3`,
// with the likely unit if there is one. nullopt: `value`, a size in SI, is in the range.
std::optional<std::string> ImplausibleRemark(std::string_view key, double value, Plausible kind);

}  // namespace palpate

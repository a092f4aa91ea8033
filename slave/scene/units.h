// Numbers with units, as in scenes and on the command line: `127 kPa`, `25mm`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

// Dimension of a number; each has its own units (deploy/scenes/README.md), and plain numbers are
// SI.
enum class Dimension : std::uint8_t {
  kNumber,        // none, or %: 5 % is 0.05
  kLength,        // m mm um nm km
  kPressure,      // Pa kPa MPa GPa TPa
  kForce,         // N mN uN
  kTime,          // s ms us
  kFrequency,     // Hz kHz
  kAngle,         // rad deg
  kDensity,       // kg/m3 g/cm3
  kSpeed,         // m/s mm/s um/s nm/s km/s
  kPixels,        // px
  kTension,       // N/m mN/m N/mm
  kVolume,        // l ml m3 cm3
  kAngularSpeed,  // rad/s deg/s
};

// Parses an integer; the text must contain only the number.
std::optional<long long> ParseInteger(std::string_view text) noexcept;

// `number`, `number unit` or `numberunit` in SI; finite decimal numbers in the notation of the C
// locale, independent of the process's locale. nullopt: not a number, not finite, a unit of
// another dimension.
std::optional<double> ParseQuantity(std::string_view text, Dimension dimension) noexcept;

// Returns the text of the quantities that ParseQuantity accepts, within `range`: "a length > 0 (m,
// mm, um, nm, km)".
std::string ExpectedQuantity(Dimension dimension, std::string_view range = {});

}  // namespace palpate

#include "slave/scene/units.h"

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <system_error>

#include "shared/text/text.h"

namespace palpate {
namespace {

struct KnownUnit {
  Dimension dimension;
  std::string_view name;
  double in_si;
};

using enum Dimension;
constexpr std::array kUnits{
    KnownUnit{kNumber, "%", 0.01},
    KnownUnit{kLength, "m", 1},
    KnownUnit{kLength, "mm", 1e-3},
    KnownUnit{kLength, "um", 1e-6},
    KnownUnit{kLength, "nm", 1e-9},
    KnownUnit{kLength, "km", 1e3},
    KnownUnit{kPressure, "Pa", 1},
    KnownUnit{kPressure, "kPa", 1e3},
    KnownUnit{kPressure, "MPa", 1e6},
    KnownUnit{kPressure, "GPa", 1e9},
    KnownUnit{kPressure, "TPa", 1e12},
    KnownUnit{kForce, "N", 1},
    KnownUnit{kForce, "mN", 1e-3},
    KnownUnit{kForce, "uN", 1e-6},
    KnownUnit{kTime, "s", 1},
    KnownUnit{kTime, "ms", 1e-3},
    KnownUnit{kTime, "us", 1e-6},
    KnownUnit{kFrequency, "Hz", 1},
    KnownUnit{kFrequency, "kHz", 1e3},
    KnownUnit{kAngle, "rad", 1},
    KnownUnit{kDensity, "kg/m3", 1},
    KnownUnit{kAngle, "deg", std::numbers::pi / 180},
    KnownUnit{kDensity, "g/cm3", 1e3},
    KnownUnit{kSpeed, "m/s", 1},
    KnownUnit{kSpeed, "mm/s", 1e-3},
    KnownUnit{kSpeed, "um/s", 1e-6},
    KnownUnit{kSpeed, "nm/s", 1e-9},
    KnownUnit{kSpeed, "km/s", 1e3},
    KnownUnit{kPixels, "px", 1},
    KnownUnit{kTension, "N/m", 1},
    KnownUnit{kTension, "mN/m", 1e-3},
    KnownUnit{kTension, "N/mm", 1e3},
    KnownUnit{kVolume, "l", 1e-3},
    KnownUnit{kVolume, "ml", 1e-6},
    KnownUnit{kVolume, "m3", 1},
    KnownUnit{kVolume, "cm3", 1e-6},
    KnownUnit{kAngularSpeed, "rad/s", 1},
    KnownUnit{kAngularSpeed, "deg/s", std::numbers::pi / 180},
};

// In the order of Dimension.
constexpr std::array kNames{"a number",        "a length",           "a pressure", "a force",
                            "a time",          "a frequency",        "an angle",   "a density",
                            "a speed",         "a number of pixels", "a tension",  "a volume",
                            "an angular speed"};

// Reads a number from the front of `text`, also with a leading plus, which from_chars does not
// accept.
template <typename Number>
std::optional<Number> TakeNumber(std::string_view* text) {
  std::string_view digits = Trimmed(*text);
  if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{}) return std::nullopt;
  digits.remove_prefix(static_cast<std::size_t>(end - digits.data()));
  *text = Trimmed(digits);
  return value;
}

// Divides for factors below one: for mm the division by 1000 rounds once, while a factor of 1e-3
// would round twice.
double InSi(double value, double factor) {
  const double inverse = std::round(1 / factor);
  return factor < 1 && std::abs(1 / factor - inverse) < 1e-3 ? value / inverse : value * factor;
}

}  // namespace

std::optional<long long> ParseInteger(std::string_view text) noexcept {
  const auto value = TakeNumber<long long>(&text);
  return text.empty() ? value : std::nullopt;
}

std::optional<double> ParseQuantity(std::string_view text, Dimension dimension) noexcept {
  const auto value = TakeNumber<double>(&text);
  if (!value || !std::isfinite(*value)) return std::nullopt;
  if (text.empty()) return value;
  for (const KnownUnit& unit : kUnits) {
    if (unit.dimension != dimension || unit.name != text) continue;
    const double si = InSi(*value, unit.in_si);
    return std::isfinite(si) ? std::optional(si) : std::nullopt;
  }
  return std::nullopt;
}

std::string ExpectedQuantity(Dimension dimension, std::string_view range) {
  std::string text(kNames[static_cast<std::size_t>(dimension)]);
  const bool is_comparison = range.starts_with('>') || range.starts_with('<');
  if (!range.empty()) text.append(is_comparison ? " " : ", ").append(range);
  std::string units(dimension == kNumber ? "plain or " : "");
  for (const KnownUnit& unit : kUnits) {
    if (unit.dimension == dimension) units.append(unit.name).append(", ");
  }
  return text.append(" (").append(units, 0, units.size() - 2).append(")");
}

}  // namespace palpate

#include "master/view/scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace palpate {
namespace {

using Colour = std::array<double, 3>;

// Pale grey over orange to dark purple: darker is more, for everybody's eyes.
constexpr std::array<Colour, 5> kStops{{
    {236, 239, 243},
    {250, 214, 145},
    {242, 142, 75},
    {205, 62, 78},
    {112, 28, 92},
}};

}  // namespace

double RoundedUp(double value, double floor) {
  if (!(value > floor)) value = floor;
  if (!std::isfinite(value)) value = 1e300;
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 2.0, 4.0, 6.0, 8.0}) {
    if (value <= step * decade * (1 + 1e-9)) return step * decade;
  }
  return 10 * decade;
}

std::string ColourOf(double share, double light) {
  const double at = std::clamp(std::isfinite(share) ? share : 0.0, 0.0, 1.0) * (kStops.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double rest = at - static_cast<double>(below);
  std::array<unsigned, 3> rgb{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double mixed = (1 - rest) * kStops[below][i] + rest * kStops[below + 1][i];
    rgb[i] = static_cast<unsigned>(std::lround(std::clamp(light, 0.0, 1.0) * mixed));
  }
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
  return text.data();
}

std::string Readable(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

}  // namespace palpate

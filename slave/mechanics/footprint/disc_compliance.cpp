#include "slave/mechanics/footprint/disc_compliance.h"

#include <cmath>
#include <numbers>

namespace palpate {

DiscCompliance OfBondedDisc(double nu) noexcept {
  constexpr double kIncompressible = 1e-8;  // 1 - 2 nu below which the logarithm's quotient is 2
  const double x = 1 - 2 * nu;
  const double quotient = x > kIncompressible ? std::log1p(2 * x) / x : 2;
  return {(1 + nu) / (2 * quotient), (7 - 8 * nu) * (1 + nu) / (16 * (1 - nu))};
}

DiscCompliance OfSlidingDisc(double nu) noexcept {
  return {(1 - nu * nu) / 2, 0};
}

DiscCompliance OfEvenLoad(double nu) noexcept {
  const double of_smooth = 16 / (3 * std::numbers::pi * std::numbers::pi);
  return {of_smooth * (1 - nu * nu), of_smooth * (1 + nu) * (1 - nu / 2)};
}

}  // namespace palpate

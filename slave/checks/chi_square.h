// The gate of a chi-square test.
#pragma once

#include <cmath>

namespace palpate {

// The quantile 0.9999 of chi-square with n >= 1 degrees of freedom, to 8 %: never too small.
// Source: Wilson and Hilferty, 1931: the cube root of chi-square / n is nearly normal.
inline double ChiSquareGate(int n) noexcept {
  // Quantile of the normal distribution for the same probability [-]. [by definition]
  constexpr double kNormalQuantile = 3.719;
  const double variance = 2.0 / (9.0 * n);
  const double root = 1 - variance + kNormalQuantile * std::sqrt(variance);
  return n * root * root * root;
}

}  // namespace palpate

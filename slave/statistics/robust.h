// Robust statistics of samples that may contain outliers. Header only. Allocation-free.
//
// Source: Huber and Ronchetti, Robust Statistics (2009), 4.
#pragma once

#include <algorithm>
#include <cmath>
#include <ranges>

namespace palpate {

// Ratio of the standard deviation of normal errors to the median of their magnitudes [-].
inline constexpr double kSigmaPerMedian = 1.4826;
// Tukey's biweight ends here [standard deviations]: 95 % efficient for normal errors.
inline constexpr double kBiweightCut = 4.685;

// Returns the median; for an even number of values the upper one of the two central values.
// `values`: not empty; their order changes.
template <std::ranges::random_access_range Values>
std::ranges::range_value_t<Values> MedianOf(Values&& values) {
  const auto middle = std::ranges::begin(values) + std::ranges::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Standard deviation of normal errors about zero. `sizes`: as for MedianOf, not negative.
template <std::ranges::random_access_range Values>
double SigmaOfSizes(Values&& sizes) {
  return kSigmaPerMedian * MedianOf(sizes);
}

// Estimates the deviation about the median of `values`, which become their distances from it.
template <std::ranges::random_access_range Values>
double SigmaAboutMedian(Values&& values) {
  const auto middle = MedianOf(values);
  for (auto& value : values) value = std::abs(value - middle);
  return SigmaOfSizes(values);
}

// Weight of an error of `u` cuts; zero from the cut on.
inline double Biweight(double u) {
  return std::abs(u) < 1 ? (1 - u * u) * (1 - u * u) : 0;
}

}  // namespace palpate

// What the eyes saw in one picture.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

struct TipObservation {
  bool found = false;
  Eigen::Vector2d p_I{0, 0};  // tip [px], sub-pixel
  double score = 0;           // normalised cross-correlation at the peak [-1, 1]
  double sigma = 0;           // one standard deviation of p_I per axis [px]
  bool reacquired = false;    // found by the search over the whole picture
};

struct Observation {
  std::uint64_t sequence = 0;
  Time sensed_at{};
  TipObservation tip;
  std::span<const Eigen::Vector2d>
      contour_I;  // control points [px], counter-clockwise as seen in S; may be empty
};

}  // namespace palpate

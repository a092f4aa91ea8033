// Coordinates of a round plate that suit a round tool anywhere on it: circles about the tool's
// centre below it and, between its edge and the rim, circles whose centres and radii change evenly.
#pragma once

#include <Eigen/Core>

namespace palpate::site {

// Frame: origin at the plate's centre, the tool's centre on the x axis at `eccentricity` >= 0, with
// eccentricity + tool < radius. Any unit.
struct NestedCircles {
  double radius = 0;        // of the plate
  double tool = 0;          // radius of the tool
  double eccentricity = 0;  // of the tool's centre

  struct Place {
    double s = 0;      // 0 at the tool's centre, 1 at its edge, 2 at the rim
    double angle = 0;  // about the centre of the circle `s`, from the x axis [rad], -pi to pi
  };
  [[nodiscard]] Eigen::Vector2d At(const Place& place) const noexcept;
  // Beyond the rim s > 2 with growing distance, as long as it is less than twice the radius.
  [[nodiscard]] Place Of(const Eigen::Vector2d& p) const noexcept;
};

}  // namespace palpate::site

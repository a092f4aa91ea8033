// The linear map between known and reported vectors, with intervals at 95 %: how much they are
// scaled, turned, mirrored, or which of their axes are exchanged.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/statistics/intervals.h"

namespace palpate {

// Means during one load that was held, or of a short stretch of a sensor's record.
struct KnownAndReported {
  Eigen::Vector3d known = Eigen::Vector3d::Zero();
  Eigen::Vector3d reported = Eigen::Vector3d::Zero();
  double sigma = 0;  // expected deviation of an axis of `reported`; loads weigh by it
};

// A permutation of the axes with signs: the reported axis axis[j] shows sign[j] times the known
// axis j.
struct AxisRelation {
  std::array<int, 3> axis{0, 1, 2};
  std::array<int, 3> sign{1, 1, 1};

  [[nodiscard]] Eigen::Matrix3d matrix() const;  // reported = matrix * known
  [[nodiscard]] bool is_permuted() const { return axis != std::array{0, 1, 2}; }
  [[nodiscard]] bool is_flipped() const { return sign != std::array{1, 1, 1}; }
};

struct MapFit {
  int loads = 0;
  int directions = 0;       // independent directions of the known vectors; 0: nothing was fitted
  bool is_decided = false;  // enough loads for intervals: two more than directions
  Eigen::Matrix3d map = Eigen::Matrix3d::Zero();         // reported = map * known
  Eigen::Matrix3d half_width = Eigen::Matrix3d::Zero();  // of the intervals of `map`
  Interval gain;                                         // common scale, whatever the direction
  // Gains of the known axes that the loads test.
  std::array<std::optional<Interval>, 3> axis_gain;
  Interval along;                 // cosine of known and reported vectors, -1 to 1
  AxisRelation relation;          // the simplest one that explains the map best
  bool relation_is_clear = true;  // and whether the data exclude another answer to "same axes?"
  // Largest angle by which a tested direction is turned, after `relation` [rad].
  Interval turn;
  double explained = 0;  // share of the reported vectors' squares that the map explains
};

// Weighted least squares over loads. `axes`: the axes that are known, 0 to 2; others are ignored.
// `repeats`: how many neighbouring loads share their errors (1: each has its own).
MapFit FitMap(const std::vector<KnownAndReported>& loads, const std::vector<int>& axes,
              double repeats = 1);

}  // namespace palpate

// The linear map between two columns of vectors, with 95 % intervals: scale, rotation, mirroring
// and exchanged axes of the second column relative to the first.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/statistics/intervals.h"

namespace palpate {

enum class Judgement : std::uint8_t { kRight, kWrong, kOpen, kUntested };
// Returns whether an interval is inside `low` to `high`, outside, or across an end (kOpen).
Judgement FindingOfInterval(const Interval& interval, double low, double high);

// `count` rows in at most 20 blocks of neighbours, which may share their errors: row i belongs to
// block (*)(i).
std::vector<int> BlocksOf(Eigen::Index count);

// The interval of a statistic from its values `without` one block each, `distance(value)` from the
// value of all. Source: delete-a-group jackknife, Wolter, Introduction to Variance Estimation
// (2007), 4.2. Infinite unless `freedom` > 0 and every distance is finite.
template <class Replicates, class Distance>
double JackknifeReach(const Replicates& without, double freedom, const Distance& distance) {
  double squares = 0;
  for (const auto& one : without) {
    const double away = distance(one);
    squares += away * away;
  }
  const auto count = static_cast<double>(without.size());
  if (!(freedom > 0) || !std::isfinite(squares)) return std::numeric_limits<double>::infinity();
  return StudentReach(freedom) * std::sqrt(squares * (count - 1) / count);
}

// Interval of the length of a mean vector, from block means of neighbouring columns of `errors`.
// nullopt: fewer than three columns.
struct MeanVector {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Interval size;  // >= 0
};
std::optional<MeanVector> MeanOf(const Eigen::Matrix3Xd& errors);

// Orthonormal directions with at least a fifth of the largest spread; `covariance`: any multiple.
using Directions = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;
Directions TestedDirections(const Eigen::Matrix3d& covariance);

// A permutation of the axes with signs: axis axis[j] of the second column shows sign[j] times axis
// j of the first.
struct AxisRelation {
  std::array<int, 3> axis{0, 1, 2};
  std::array<int, 3> sign{1, 1, 1};

  [[nodiscard]] Eigen::Matrix3d matrix() const;
  [[nodiscard]] bool is_permuted() const { return axis != std::array{0, 1, 2}; }
  [[nodiscard]] bool is_flipped() const { return sign != std::array{1, 1, 1}; }
};

// A scale by the regression of the second column on the first (`forth`), and by the inverse
// regression (`back`). If the second column is a prediction that tends to its mean, `forth` is too
// small; with noise in it `back` is too large. The true scale is between them. Source: Frisch
// (1934), errors in variables.
struct Scale {
  Interval forth, back;

  [[nodiscard]] Interval Both() const;
  // Right if either scale is right; wrong if both are wrong on the same side.
  [[nodiscard]] Judgement FindingWithin(double tolerance) const;
};

struct VectorMap {
  int directions = 0;       // independent directions of the first column; 0: no fit
  bool is_decided = false;  // enough blocks for intervals: three more than directions
  Eigen::Matrix3d map = Eigen::Matrix3d::Zero();         // second = map * first + offset
  Eigen::Matrix3d half_width = Eigen::Matrix3d::Zero();  // of the intervals of `map`
  Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();     // the same by the inverse regression
  Scale gain;                                            // common scale in all directions
  std::array<std::optional<Scale>, 3> axis_gain;         // of the first column's tested axes
  Interval along;                                        // cosine of the columns, -1 to 1
  AxisRelation relation;          // the simplest one that explains the map best
  bool relation_is_clear = true;  // the data exclude another answer to "are the axes the same?"
  Interval turn;                  // largest angle of a tested direction, after `relation` [rad]
  double explained = 0;           // share of the second column's variance that the map explains
};

// Least squares about the means. `first`, `second`: 3 x rows, finite; rows of axes that are not in
// `axes` are ignored. `block`: of each row, from 0 without gaps; rows of a block share their
// errors.
VectorMap FitMap(const Eigen::Matrix3Xd& first, const Eigen::Matrix3Xd& second,
                 const std::vector<int>& block, const std::vector<int>& axes);

}  // namespace palpate

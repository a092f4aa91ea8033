// Search of an array in an image: the order from three neighbours outwards, the dot near a
// position, and extrapolation from neighbours.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/vision/dots/dot.h"

namespace palpate {

// The next dot is expected at sum weight place(parent), which is exact under affine maps; parents
// come before it in the order, the nearest first.
struct GrowthStep {
  static constexpr std::size_t kMostParents = 8;
  int dot = 0;
  int parents = 0;
  std::array<int, kMostParents> parent{};
  std::array<double, kMostParents> weight{};
};
using Growth = std::vector<GrowthStep>;  // the first three, not collinear, have no parents

// Positions are finite and differ. Throws std::invalid_argument: all nearly collinear.
Growth GrowthFrom(const std::vector<Eigen::Vector2d>& layout, std::size_t anchor);
// The dot in the middle, then up to `most` in all, far from each other.
std::vector<std::size_t> SpreadAnchors(const std::vector<Eigen::Vector2d>& layout,
                                       std::size_t most);
// Of each dot, up to `most` others, nearest first.
std::vector<std::vector<int>> NearestNeighbours(const std::vector<Eigen::Vector2d>& layout,
                                                std::size_t most);

// The dots of one image, indexed by position.
class DotIndex {
 public:
  // Allocates only when there are more dots than ever before.
  void Build(std::span<const Dot> dots, std::span<const int> which);
  // The nearest of them to `place` within `reach` [px]; -1: none.
  [[nodiscard]] int Nearest(std::span<const Dot> dots, const Eigen::Vector2d& place,
                            double reach) const noexcept;

 private:
  static constexpr int kCells = 16;  // along each axis
  [[nodiscard]] int Cell(double offset) const noexcept;

  std::vector<int> heads_, next_;  // chains of dots per cell
  Eigen::Vector2d corner_{0, 0};
  double cell_ = 1;  // [px]
};

// Extrapolates a point from its neighbours' motion: least squares of an affine map.
class AffineMove {
 public:
  // `point`: where it was.
  explicit AffineMove(const Eigen::Vector2d& point) : point_(point) {}
  // A neighbour was at `before` and is at `now`; the nearer ones weigh more.
  void Add(const Eigen::Vector2d& before, const Eigen::Vector2d& now) noexcept {
    const Eigen::Vector2d d = before - point_, move = now - before;
    const double weight = 1 / (d.squaredNorm() + 1e-12);
    ++count_;
    sum_ += weight;
    d_ += weight * d;
    move_ += weight * move;
    dd_ += weight * d * d.transpose();
    move_d_ += weight * move * d.transpose();
  }
  [[nodiscard]] int count() const { return count_; }
  // The present position of the point. Collinear neighbours, or fewer than three, determine no
  // motion across their line: there they shift as one. No neighbour: NaN.
  [[nodiscard]] Eigen::Vector2d Carry() const noexcept {
    if (count_ == 0) {
      return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    }
    const Eigen::Vector2d d = d_ / sum_, move = move_ / sum_;
    Eigen::Matrix2d D = dd_ - sum_ * d * d.transpose();
    const Eigen::Matrix2d M = move_d_ - sum_ * move * d.transpose();
    const double ridge = 1e-6 * dd_.trace();
    D(0, 0) += ridge;
    D(1, 1) += ridge;
    const double determinant = D(0, 0) * D(1, 1) - D(0, 1) * D(1, 0);
    if (!(determinant > 0)) return point_ + move;
    Eigen::Matrix2d inverse;
    inverse << D(1, 1), -D(0, 1), -D(1, 0), D(0, 0);
    return point_ + move - M * inverse * d / determinant;
  }

 private:
  Eigen::Vector2d point_;
  int count_ = 0;
  double sum_ = 0;
  Eigen::Vector2d d_{0, 0}, move_{0, 0};
  Eigen::Matrix2d dd_ = Eigen::Matrix2d::Zero(), move_d_ = Eigen::Matrix2d::Zero();
};

}  // namespace palpate

#include "slave/vision/dots/dot_growth.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include <Eigen/LU>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Places = std::vector<Eigen::Vector2d>;

// Determinants of parents, their distances scaled to 1: well off one line, and barely.
constexpr double kSpread = 1e-2, kBarelySpread = 1e-12;

Eigen::Vector2d Middle(const Places& layout) {
  Eigen::Vector2d sum(0, 0);
  for (const Eigen::Vector2d& p : layout) sum += p;
  return sum / static_cast<double>(layout.size());
}

// Indices by distance from `place`.
std::vector<int> ByDistance(const Places& layout, const Eigen::Vector2d& place,
                            std::vector<int> which) {
  const auto distance = [&](int k) { return (layout[Index(k)] - place).norm(); };
  std::stable_sort(which.begin(), which.end(),
                   [&](int a, int b) { return distance(a) < distance(b); });
  return which;
}

std::vector<int> All(std::size_t count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// The smallest weights with sum 1 that give `place`; false: the parents spread less than `least`.
bool Weigh(const Places& layout, const Eigen::Vector2d& place, double least, GrowthStep* step) {
  Eigen::Matrix<double, 3, Eigen::Dynamic> A(3, step->parents);
  double scale = 0;
  for (int p = 0; p < step->parents; ++p) {
    const auto parent = Index(step->parent[Index(p)]);
    A.col(p) << 1, layout[parent] - place;
    scale = std::max(scale, (layout[parent] - place).norm());
  }
  A.bottomRows(2) /= scale;
  const Eigen::Matrix3d square = A * A.transpose();
  if (!(std::abs(square.determinant()) > least)) return false;
  const Eigen::VectorXd weights =
      A.transpose() * (square.inverse() * Eigen::Vector3d(1, 0, 0)).eval();
  for (int p = 0; p < step->parents; ++p) step->weight[Index(p)] = weights[p];
  return true;
}

// The nearest of those already there, as many as it takes not to lie on one line.
GrowthStep StepTo(const Places& layout, int dot, const std::vector<int>& there) {
  GrowthStep step;
  step.dot = dot;
  const Eigen::Vector2d& place = layout[Index(dot)];
  const std::vector<int> nearest = ByDistance(layout, place, there);
  const std::size_t most = std::min(nearest.size(), GrowthStep::kMostParents);
  for (std::size_t n = std::min<std::size_t>(4, most); n <= most; ++n) {
    step.parents = static_cast<int>(n);
    std::copy_n(nearest.begin(), n, step.parent.begin());
    if (Weigh(layout, place, kSpread, &step)) return step;
  }
  step.parents = 4;  // the nearest, and the first three, which do not lie on one line
  step.parent = {nearest[0], there[0], there[1], there[2]};
  if (!Weigh(layout, place, kBarelySpread, &step)) {
    throw std::invalid_argument("the dots of the layout are nearly collinear");
  }
  return step;
}

}  // namespace

Growth GrowthFrom(const Places& layout, std::size_t anchor) {
  const Eigen::Vector2d& origin = layout[anchor];
  const std::vector<int> order = ByDistance(layout, origin, All(layout.size()));
  std::vector<int> there{order[0], order[1]};
  const Eigen::Vector2d a = layout[Index(order[1])] - origin;
  for (std::size_t i = 2; i < order.size() && there.size() < 3; ++i) {
    const Eigen::Vector2d b = layout[Index(order[i])] - origin;
    if (std::abs(a.x() * b.y() - a.y() * b.x()) > 0.3 * a.norm() * b.norm()) {
      there.push_back(order[i]);
    }
  }
  if (there.size() < 3) throw std::invalid_argument("the dots of the layout are collinear");
  Growth growth(3);
  for (std::size_t i = 0; i < 3; ++i) growth[i].dot = there[i];
  std::vector<char> done(layout.size(), 0);
  for (const int k : there) done[Index(k)] = 1;
  while (there.size() < layout.size()) {  // the one nearest to any that is there
    int next = -1;
    double least = std::numeric_limits<double>::infinity();
    for (const int k : order) {
      if (done[Index(k)] != 0) continue;
      for (const int other : there) {
        const double distance = (layout[Index(k)] - layout[Index(other)]).norm();
        if (distance < least) least = distance, next = k;
      }
    }
    growth.push_back(StepTo(layout, next, there));
    there.push_back(next);
    done[Index(next)] = 1;
  }
  return growth;
}

std::vector<std::size_t> SpreadAnchors(const Places& layout, std::size_t most) {
  const std::vector<int> order = ByDistance(layout, Middle(layout), All(layout.size()));
  // The inner half has neighbours on all sides.
  const std::size_t inner = std::max(std::min(layout.size(), most), layout.size() / 2);
  std::vector<std::size_t> anchors{Index(order[0])};
  while (anchors.size() < std::min(most, inner)) {
    std::size_t farthest = anchors[0];
    double most_apart = 0;
    for (std::size_t i = 0; i < inner; ++i) {
      const auto k = Index(order[i]);
      double apart = std::numeric_limits<double>::infinity();
      for (const std::size_t anchor : anchors) {
        apart = std::min(apart, (layout[k] - layout[anchor]).norm());
      }
      if (apart > most_apart) most_apart = apart, farthest = k;
    }
    if (!(most_apart > 0)) break;
    anchors.push_back(farthest);
  }
  return anchors;
}

std::vector<std::vector<int>> NearestNeighbours(const Places& layout, std::size_t most) {
  std::vector<std::vector<int>> neighbours;
  for (std::size_t k = 0; k < layout.size(); ++k) {
    std::vector<int> nearest = ByDistance(layout, layout[k], All(layout.size()));
    std::erase(nearest, static_cast<int>(k));
    nearest.resize(std::min(nearest.size(), most));
    neighbours.push_back(std::move(nearest));
  }
  return neighbours;
}

void DotIndex::Build(std::span<const Dot> dots, std::span<const int> which) {
  heads_.assign(Index(kCells * kCells), -1);
  next_.assign(dots.size(), -1);
  if (which.empty()) return;
  const auto at = [&](int dot) { return dots[Index(dot)].centre; };
  Eigen::Vector2d low = at(which[0]), high = low;
  for (const int dot : which) {
    low = low.cwiseMin(at(dot));
    high = high.cwiseMax(at(dot));
  }
  corner_ = low;
  cell_ = std::max(1.0, (high - low).maxCoeff() / kCells);
  for (const int dot : which) {
    const Eigen::Vector2d offset = at(dot) - corner_;
    int& head = heads_[Index(Cell(offset.y()) * kCells + Cell(offset.x()))];
    next_[Index(dot)] = head;
    head = dot;
  }
}

int DotIndex::Cell(double offset) const noexcept {
  return static_cast<int>(std::clamp(offset / cell_, 0.0, kCells - 1.0));
}

int DotIndex::Nearest(std::span<const Dot> dots, const Eigen::Vector2d& place,
                      double reach) const noexcept {
  if (heads_.empty() || !place.allFinite() || !(reach >= 0)) return -1;
  const Eigen::Vector2d offset = place - corner_;
  int nearest = -1;
  double least = reach * reach;
  for (int j = Cell(offset.y() - reach); j <= Cell(offset.y() + reach); ++j) {
    for (int i = Cell(offset.x() - reach); i <= Cell(offset.x() + reach); ++i) {
      for (int dot = heads_[Index(j * kCells + i)]; dot >= 0; dot = next_[Index(dot)]) {
        const double distance = (dots[Index(dot)].centre - place).squaredNorm();
        if (distance > least) continue;
        least = distance;
        nearest = dot;
      }
    }
  }
  return nearest;
}

}  // namespace palpate

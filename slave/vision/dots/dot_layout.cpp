#include "slave/vision/dots/dot_layout.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "shared/text/text.h"
#include "slave/scene/contour_file.h"

namespace palpate {
namespace {

struct Choice {
  std::vector<Eigen::Vector2d> points;  // nearest first
  bool symmetric = false;  // whether all points at the distance of the last one are included
};

Choice Nearest(int count, const Eigen::Vector2d& spacing, const Eigen::Vector2d& centre) {
  const double reach = spacing.maxCoeff() * (std::sqrt(count) + 2);
  const int columns = static_cast<int>(std::min<double>(count, reach / spacing.x())) + 1;
  const int rows = static_cast<int>(std::min<double>(count, reach / spacing.y())) + 1;
  std::vector<Eigen::Vector2d> points;
  for (int j = -rows; j <= rows; ++j) {
    for (int i = -columns; i <= columns; ++i) {
      points.push_back((Eigen::Vector2d(i, j) + centre).cwiseProduct(spacing));
    }
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  const auto last = static_cast<std::size_t>(count);
  const bool symmetric = points[last].norm() > points[last - 1].norm() * (1 + 1e-9);
  points.resize(last);
  return {std::move(points), symmetric};
}

}  // namespace

std::vector<Eigen::Vector2d> LatticePlaces(int count, const Eigen::Vector2d& spacing) {
  Require(count >= 1 && count <= 400, "count", count, "1 to 400");
  if (!(spacing.allFinite() && spacing.minCoeff() > 0 &&
        spacing.maxCoeff() < 1e3 * spacing.minCoeff())) {
    throw std::invalid_argument("spacing = [" + std::to_string(spacing.x()) + ", " +
                                std::to_string(spacing.y()) +
                                "]: expected two lengths > 0, at most 1000 to 1");
  }
  Choice best = Nearest(count, spacing, {0, 0});
  for (const Eigen::Vector2d& centre :
       {Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(0.5, 0), Eigen::Vector2d(0, 0.5)}) {
    if (best.symmetric) break;
    Choice other = Nearest(count, spacing, centre);
    if (other.symmetric) best = std::move(other);
  }
  std::sort(best.points.begin(), best.points.end(), [&](const auto& a, const auto& b) {
    const double rows = (a.y() - b.y()) / spacing.y();
    return std::abs(rows) > 0.25 ? rows < 0 : a.x() < b.x();
  });
  return best.points;
}

std::vector<Eigen::Vector2d> DotPlaces(const PointTracking& points) {
  if (points.layout.empty()) return LatticePlaces(points.count, points.spacing);
  return ReadContourFile(points.layout);
}

}  // namespace palpate

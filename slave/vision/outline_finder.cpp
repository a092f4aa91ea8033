#include "slave/vision/outline_finder.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <vector>

#include <Eigen/Eigenvalues>
#include <opencv2/imgproc.hpp>

#include "slave/vision/rest_contour.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kTolerance = 0.7;                // of the polygon [px] [by definition]
constexpr double kPointSpacing = 12;              // of the snake's points [px]
constexpr int kMinPoints = 60, kMaxPoints = 200;  // of the snake
constexpr std::size_t kSidePoints = 6;            // smallest number of edge points on a fitted side
// Largest distance of a corner from the vertices of the edge beside it [px], which does not contain
// it.
constexpr double kCornerReach = 14;
constexpr double kMinCornerTurn = 0.17;  // between sides that meet in a corner [rad]

struct Line {
  Vector2d p{0, 0}, d{0, 0};  // [px]; unit direction
};

// A piece of the edge, from the point `first` to the point `last` in the order of the edge.
struct Side {
  std::size_t first = 0, last = 0;
  std::optional<Line> line;  // nullopt: too short
};

// Total least squares.
Line FitLine(const Curve& edge, std::size_t first, std::size_t count) {
  Vector2d mean(0, 0);
  for (std::size_t i = 0; i < count; ++i) mean += edge[(first + i) % edge.size()];
  mean /= static_cast<double>(count);
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2d r = edge[(first + i) % edge.size()] - mean;
    scatter += r * r.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(scatter);
  return {mean, solver.eigenvectors().col(1)};
}

// Indices of the points of `edge` that a polygon within the tolerance needs (Douglas-Peucker).
std::vector<std::size_t> Vertices(const Curve& edge) {
  std::vector<cv::Point2f> points, kept;
  for (const Vector2d& p : edge) {
    points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  cv::approxPolyDP(points, kept, kTolerance, true);
  std::vector<std::size_t> indices;
  for (const cv::Point2f& p : kept) {
    indices.push_back(static_cast<std::size_t>(std::ranges::find(points, p) - points.begin()));
  }
  std::ranges::sort(indices);
  return indices;
}

std::vector<Side> SidesOf(const Curve& edge, const std::vector<std::size_t>& vertices) {
  std::vector<Side> sides;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    Side side{vertices[k], vertices[(k + 1) % vertices.size()], std::nullopt};
    const std::size_t count = (side.last + edge.size() - side.first) % edge.size() + 1;
    if (count >= kSidePoints) side.line = FitLine(edge, side.first, count);
    sides.push_back(side);
  }
  return sides;
}

std::optional<Vector2d> Corner(const Line& a, const Line& b) {
  const double sine = a.d.x() * b.d.y() - a.d.y() * b.d.x();
  if (std::abs(sine) < std::sin(kMinCornerTurn)) return std::nullopt;
  const Vector2d between = b.p - a.p;
  return a.p + (between.x() * b.d.y() - between.y() * b.d.x()) / sine * a.d;
}

// Extends straight sides to their common corner across short pieces between them.
Curve WithCorners(const Curve& edge, std::vector<Side> sides) {
  const auto straight = std::ranges::find_if(sides, [](const Side& side) { return !!side.line; });
  if (straight != sides.end()) std::ranges::rotate(sides, straight);
  Curve polygon;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    const Side& side = sides[k];
    if (!side.line) {
      polygon.push_back(edge[side.last]);
      continue;
    }
    // Finds the next straight side if only short pieces are before it.
    std::size_t next = k + 1;
    while (next < k + 3 && !sides[next % sides.size()].line) ++next;
    const Side& other = sides[next % sides.size()];
    const auto corner = other.line ? Corner(*side.line, *other.line) : std::nullopt;
    const bool is_near = corner && (*corner - edge[side.last]).norm() < kCornerReach &&
                         (*corner - edge[other.first]).norm() < kCornerReach;
    if (!is_near) {
      polygon.push_back(edge[side.last]);
      continue;
    }
    polygon.push_back(*corner);
    k = next - 1;  // drops the pieces between
  }
  return polygon;
}

}  // namespace

FoundOutline FindOutlineNear(const cv::Mat& image, CurveView near) {
  if (!near.empty() && near.size() < 3) {
    throw std::invalid_argument("near = " + std::to_string(near.size()) +
                                " points: expected three or more, or none");
  }
  if (CrossesItself(near)) {
    throw std::invalid_argument(
        "near: its sides cross: expected points in order around the object");
  }
  const GreyFormat format(image);
  ContourTracking options;
  if (!near.empty()) {
    options.start.assign(near.begin(), near.end());
    options.control_points =
        std::clamp(static_cast<int>(CurveLength(near) / kPointSpacing), kMinPoints, kMaxPoints);
  }
  const RestContour found = FindRestContour(options, image, format, 0, false);
  const auto points = static_cast<double>(found.edge.size());
  FoundOutline outline;
  outline.polygon = WithCorners(found.edge, SidesOf(found.edge, Vertices(found.edge)));
  outline.clear = std::min(1.0, points * RefinementOptions().spacing / CurveLength(found.outline));
  return outline;
}

}  // namespace palpate

#include "slave/mesh/outline.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

namespace palpate {
namespace {

using Loop = std::vector<Eigen::Vector2d>;
constexpr double kSamePoint = 1e-12;  // of the bounding box's larger side
constexpr double kNoArea = 1e-12;     // smallest area relative to the square of the larger side

std::string NameOf(std::size_t loop) {
  return loop == 0 ? "outer loop" : "hole " + std::to_string(loop - 1);
}

[[noreturn]] void Refuse(std::size_t loop, const std::string& what) {
  throw std::invalid_argument(NameOf(loop) + ": " + what);
}

// Returns the side of the line a-b on which `p` is: 1 left, -1 right, 0 on it, to rounding at unit
// size.
int SideOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  const double area = Cross(b - a, p - a);
  return area > 1e-15 ? 1 : area < -1e-15 ? -1 : 0;
}

bool BoxesOverlap(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                  const Eigen::Vector2d& d) {
  return (a.cwiseMin(b).array() <= c.cwiseMax(d).array()).all() &&
         (c.cwiseMin(d).array() <= a.cwiseMax(b).array()).all();
}

// Returns whether the closed segments a-b and c-d share a point.
bool SegmentsIntersect(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                       const Eigen::Vector2d& d) {
  return BoxesOverlap(a, b, c, d) && SideOf(a, b, c) * SideOf(a, b, d) <= 0 &&
         SideOf(c, d, a) * SideOf(c, d, b) <= 0;
}

void CheckPoints(const Loop& loop, std::size_t index) {
  if (loop.size() < 3) {
    Refuse(index, std::to_string(loop.size()) + " points: expected three or more");
  }
  for (std::size_t i = 0; i < loop.size(); ++i) {
    if (!loop[i].allFinite()) {
      Refuse(index, "point " + std::to_string(i) + " is not finite");
    }
  }
}

// Returns the loops scaled to size one at the origin, so that tolerances are the same for sizes
// from 1 nm to 1 km.
std::vector<Loop> Normalised(const Outline& outline) {
  std::vector<Loop> loops{outline.outer};
  loops.insert(loops.end(), outline.holes.begin(), outline.holes.end());
  for (std::size_t i = 0; i < loops.size(); ++i) CheckPoints(loops[i], i);
  Eigen::AlignedBox2d box;
  for (const auto& p : loops[0]) box.extend(p);
  const double size = box.sizes().maxCoeff();
  if (!std::isnormal(size)) Refuse(0, "all points coincide, or lie beyond every number");
  for (auto& loop : loops) {
    for (auto& p : loop) p = (p - box.min()) / size;
  }
  return loops;
}

void CheckLoop(const Loop& loop, std::size_t index) {
  const std::size_t n = loop.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    if ((loop[next] - loop[i]).norm() <= kSamePoint) {
      Refuse(index, "points " + std::to_string(i) + " and " + std::to_string(next) +
                        " are the same: expected distinct points, the first not repeated");
    }
  }
  if (std::abs(SignedArea(loop)) <= kNoArea) Refuse(index, "encloses no area");
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d& a = loop[i];
    const Eigen::Vector2d& b = loop[(i + 1) % n];
    const Eigen::Vector2d& c = loop[(i + 2) % n];
    const bool folds_back = SideOf(a, b, c) == 0 && (b - a).dot(c - b) < 0;
    if (folds_back) {
      Refuse(index, "folds back on itself at point " + std::to_string((i + 1) % n));
    }
    const std::size_t last = i == 0 ? n - 1 : n;  // the edges i and last share a point
    for (std::size_t j = i + 2; j < last; ++j) {
      if (SegmentsIntersect(a, b, loop[j], loop[(j + 1) % n])) {
        Refuse(index, "edges " + std::to_string(i) + " and " + std::to_string(j) +
                          " cross or touch: expected a simple polygon");
      }
    }
  }
}

bool EdgesMeet(const Loop& one, const Loop& other) {
  for (std::size_t i = 0; i < one.size(); ++i) {
    for (std::size_t j = 0; j < other.size(); ++j) {
      if (SegmentsIntersect(one[i], one[(i + 1) % one.size()], other[j],
                            other[(j + 1) % other.size()])) {
        return true;
      }
    }
  }
  return false;
}

// Loops without intersections are separate or nested, which one point of each determines.
void CheckPair(const std::vector<Loop>& loops, std::size_t i, std::size_t j) {
  if (EdgesMeet(loops[i], loops[j])) Refuse(j, "crosses or touches the " + NameOf(i));
  const bool inside = Contains({loops[i], {}}, loops[j][0]);
  if (i == 0 && !inside) Refuse(j, "lies outside the outer loop");
  if (i > 0 && (inside || Contains({loops[j], {}}, loops[i][0]))) {
    Refuse(j, "overlaps " + NameOf(i));
  }
}

// Applies the even-odd rule to a ray towards +x.
bool IsInside(const std::vector<Eigen::Vector2d>& loop, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
    const Eigen::Vector2d& a = loop[i];
    const Eigen::Vector2d& b = loop[j];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y())) inside = !inside;
  }
  return inside;
}

}  // namespace

int BoundaryMesh::Next(int i) const {
  const auto end = std::ranges::upper_bound(loop_begin, i);
  return i + 1 < *end ? i + 1 : *(end - 1);
}

int BoundaryMesh::Previous(int i) const {
  const auto end = std::ranges::upper_bound(loop_begin, i);
  return i > *(end - 1) ? i - 1 : *end - 1;
}

double SignedArea(const std::vector<Eigen::Vector2d>& loop) {
  double twice = 0;  // relative to the first point: no cancellation far from the origin
  for (std::size_t i = 2; i < loop.size(); ++i) {
    twice += Cross(loop[i - 1] - loop[0], loop[i] - loop[0]);
  }
  return 0.5 * twice;
}

Eigen::Vector2d Centroid(const std::vector<Eigen::Vector2d>& loop) {
  double twice = 0;
  Eigen::Vector2d moment(0, 0);  // six times the first moment about the first point
  for (std::size_t i = 2; i < loop.size(); ++i) {
    const Eigen::Vector2d u = loop[i - 1] - loop[0];
    const Eigen::Vector2d v = loop[i] - loop[0];
    const double cross = Cross(u, v);
    twice += cross;
    moment += cross * (u + v);
  }
  return loop[0] + moment / (3 * twice);
}

bool Contains(const Outline& outline, const Eigen::Vector2d& p) {
  return IsInside(outline.outer, p) &&
         std::ranges::none_of(outline.holes, [&](const auto& hole) { return IsInside(hole, p); });
}

void CheckOutline(const Outline& outline) {
  const std::vector<Loop> loops = Normalised(outline);
  for (std::size_t i = 0; i < loops.size(); ++i) CheckLoop(loops[i], i);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    for (std::size_t j = i + 1; j < loops.size(); ++j) CheckPair(loops, i, j);
  }
}

}  // namespace palpate

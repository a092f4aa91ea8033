#include "shared/mesh/tracked_bodies.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "shared/mesh/boundary_patch.h"
#include "shared/mesh/outline_check.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Loop = std::vector<Vector2d>;

constexpr double kSamePoint = 1e-9;  // of the polygon's larger side
constexpr double kNoArea = 1e-12;    // of the square of it

// A polygon with the place it was given in.
struct Tracked {
  Loop loop;
  double area = 0;  // [m^2], positive
  std::size_t index = 0;
  int parent = -1;  // the innermost polygon around it
  int depth = 0;    // how many lie around it
};

std::string NameOf(const Tracked& tracked) {
  return "polygon " + std::to_string(tracked.index);
}

double LargerSide(const Loop& loop) {
  Vector2d low = loop.front(), high = low;
  for (const auto& p : loop) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).maxCoeff();
}

Loop WithoutRepeatedPoints(const Loop& given) {
  Loop loop;
  const double near = kSamePoint * LargerSide(given);
  for (const auto& p : given) {
    if (loop.empty() || !((p - loop.back()).cwiseAbs().maxCoeff() <= near)) loop.push_back(p);
  }
  while (loop.size() > 1 && (loop.front() - loop.back()).cwiseAbs().maxCoeff() <= near) {
    loop.pop_back();
  }
  return loop;
}

// What bounds an area, largest first: a polygon comes after those around it.
std::vector<Tracked> Cleaned(const std::vector<Loop>& polygons, double smallest_area) {
  std::vector<Tracked> all;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    Tracked tracked{{}, 0, i, -1, 0};
    if (polygons[i].empty()) continue;
    if (!std::ranges::all_of(polygons[i], [](const auto& p) { return p.allFinite(); })) {
      throw std::invalid_argument(NameOf(tracked) + ": a point is not finite");
    }
    tracked.loop = WithoutRepeatedPoints(polygons[i]);
    if (tracked.loop.size() < 3) continue;
    const double side = LargerSide(tracked.loop);
    tracked.area = std::abs(SignedArea(tracked.loop));
    if (!(tracked.area > std::max(smallest_area, kNoArea * side * side))) continue;
    try {
      CheckOutline({tracked.loop, {}});
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(NameOf(tracked) + ": " + error.what());
    }
    all.push_back(std::move(tracked));
  }
  std::ranges::stable_sort(all, std::ranges::greater{}, &Tracked::area);
  return all;
}

// Polygons that do not meet lie apart or one in the other.
void Nest(std::vector<Tracked>* all) {
  for (std::size_t i = 0; i < all->size(); ++i) {
    Tracked& inner = (*all)[i];
    for (std::size_t j = 0; j < i; ++j) {
      const Tracked& outer = (*all)[j];
      if (LoopsMeet(outer.loop, inner.loop)) {
        throw std::invalid_argument(NameOf(outer) + " crosses or touches " + NameOf(inner));
      }
      if (!Contains({outer.loop, {}}, inner.loop.front())) continue;
      inner.parent = static_cast<int>(j);  // the later, the smaller
      ++inner.depth;
    }
  }
}

Loop Directed(Loop loop, bool counter_clockwise) {
  if ((SignedArea(loop) > 0) != counter_clockwise) std::reverse(loop.begin() + 1, loop.end());
  return loop;
}

double DistanceToBody(const Outline& body, const Vector2d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  const auto visit = [&](const Loop& loop) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const BoundaryElement edge{loop[i], loop[(i + 1) % loop.size()]};
      nearest = std::min(nearest, DistanceTo(edge, p));
    }
  };
  visit(body.outer);
  for (const auto& hole : body.holes) visit(hole);
  return nearest;
}

}  // namespace

std::vector<Outline> BodiesOf(const std::vector<Loop>& polygons, double smallest_area) {
  std::vector<Tracked> all = Cleaned(polygons, smallest_area);
  Nest(&all);
  std::vector<Outline> bodies;
  std::vector<std::size_t> body_of(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].depth % 2 == 0) {
      body_of[i] = bodies.size();
      bodies.push_back({Directed(all[i].loop, true), {}});
    } else {
      Outline& body = bodies[body_of[static_cast<std::size_t>(all[i].parent)]];
      body.holes.push_back(Directed(all[i].loop, false));
    }
  }
  if (bodies.empty()) {
    throw std::invalid_argument(std::to_string(polygons.size()) +
                                " polygons, none of which bounds an area: accepted is at least one "
                                "of three points or more");
  }
  return bodies;
}

int BodyUnder(std::span<const Outline> bodies, const Vector2d& tip) {
  if (!tip.allFinite()) return -1;
  int nearest = -1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double distance = Contains(bodies[i], tip) ? 0 : DistanceToBody(bodies[i], tip);
    if (distance < least) {
      least = distance;
      nearest = static_cast<int>(i);
    }
  }
  return nearest;
}

}  // namespace palpate

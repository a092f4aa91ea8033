#include "slave/mesh/boundary_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

constexpr double kPlaceTolerance = 1e-9;  // of the length unit
constexpr double kWidthSlack = 1e-9;      // relative

// Returns the parameter of the point nearest to `p` on the element, 0 at a to 1 at b.
double NearestParameter(const BoundaryElement& element, const Eigen::Vector2d& p) noexcept {
  const Eigen::Vector2d edge = element.b - element.a;
  return std::clamp((p - element.a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
}

// A run of neighbouring elements: the first one and how many follow it, itself included.
struct Run {
  int first = 0;
  int count = 0;
};

// Counts the steps from `element` in one direction while midpoints are within `reach` of the
// position, which is `offset` [m] from the element's midpoint against that direction.
template <typename Step>
int StepsWithin(const BoundaryMesh& mesh, int element, double offset, double reach, int most,
                Step step) noexcept {
  int steps = 0;
  while (steps < most) {
    const int next = step(element);
    const auto length = [&](int i) { return mesh.elements[static_cast<std::size_t>(i)].length(); };
    offset += 0.5 * (length(element) + length(next));
    if (!(offset <= reach)) break;
    element = next;
    ++steps;
  }
  return steps;
}

Run FindRun(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& place,
            double width) noexcept {
  const bool usable =
      element >= 0 && element < mesh.size() && place.allFinite() && std::isfinite(width);
  if (!usable || width < 0) return {};
  const auto& own = mesh.elements[static_cast<std::size_t>(element)];
  const double offset = (0.5 - NearestParameter(own, place)) * own.length();
  const double reach = 0.5 * width * (1 + kWidthSlack);

  const auto loop_end = std::ranges::upper_bound(mesh.loop_begin, element);
  const int loop_size = *loop_end - *(loop_end - 1);
  const int ahead =
      StepsWithin(mesh, element, offset, reach, loop_size - 1, [&](int i) { return mesh.Next(i); });
  const int behind = StepsWithin(mesh, element, -offset, reach, loop_size - 1 - ahead,
                                 [&](int i) { return mesh.Previous(i); });
  const bool reaches_neighbours_only = std::abs(offset) > reach && ahead + behind > 0;
  Run run{element, ahead + behind + (reaches_neighbours_only ? 0 : 1)};
  for (int i = 0; i < behind; ++i) run.first = mesh.Previous(run.first);
  if (reaches_neighbours_only && ahead > 0) run.first = mesh.Next(element);
  return run;
}

}  // namespace

double DistanceTo(const BoundaryElement& element, const Eigen::Vector2d& p) noexcept {
  const double s = NearestParameter(element, p);
  return (element.a + s * (element.b - element.a) - p).norm();
}

int FindElement(const BoundaryMesh& mesh, const Eigen::Vector2d& p) noexcept {
  if (!p.allFinite()) return -1;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& element : mesh.elements) nearest = std::min(nearest, DistanceTo(element, p));
  const double limit = nearest + kPlaceTolerance * mesh.length_unit;
  for (int i = mesh.size() - 1; i >= 0; --i) {
    if (DistanceTo(mesh.elements[static_cast<std::size_t>(i)], p) <= limit) return i;
  }
  return -1;
}

int PatchElements(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& place, double width,
                  std::span<int> patch) noexcept {
  const Run run = FindRun(mesh, element, place, width);
  int current = run.first;
  for (std::size_t i = 0; i < std::min(patch.size(), static_cast<std::size_t>(run.count)); ++i) {
    patch[i] = current;
    current = mesh.Next(current);
  }
  return run.count;
}

std::vector<int> PatchElements(const BoundaryMesh& mesh, int element, const Eigen::Vector2d& place,
                               double width) {
  std::vector<int> patch(static_cast<std::size_t>(FindRun(mesh, element, place, width).count));
  PatchElements(mesh, element, place, width, patch);
  return patch;
}

}  // namespace palpate

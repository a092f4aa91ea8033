#include "master/view/rest_outline.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "shared/mesh/surface_patch.h"

namespace palpate {
namespace {

const double kSharp = std::cos(std::numbers::pi / 6);

bool IsDrawn(const SurfaceMesh& surface, const Viewpoint& view, const std::vector<int>& faces) {
  if (faces.size() != 2) return true;
  const Eigen::Vector3d one = Normal(surface, faces[0]), other = Normal(surface, faces[1]);
  const bool seen = view.Nearness(one) > 0, other_seen = view.Nearness(other) > 0;
  return seen != other_seen || (seen && one.dot(other) < kSharp);
}

}  // namespace

std::vector<std::array<int, 2>> VisibleOutline(const SurfaceMesh& surface, const Viewpoint& view) {
  std::map<std::array<int, 2>, std::vector<int>> faces_of;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& triangle = surface.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangle[i], triangle[(i + 1) % 3]);
      faces_of[{low, high}].push_back(static_cast<int>(t));
    }
  }
  std::vector<std::array<int, 2>> edges;
  for (const auto& [edge, faces] : faces_of) {
    if (IsDrawn(surface, view, faces)) edges.push_back(edge);
  }
  return edges;
}

}  // namespace palpate

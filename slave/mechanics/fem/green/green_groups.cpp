#include "slave/mechanics/fem/green/green_groups.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "slave/mesh/index.h"
#include "slave/mesh/mesh_census.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kGroupsVersion = 3;  // version of the format on disk

// Position along Morton's curve through the bounding box, 20 bits a side.
std::uint64_t CurvePosition(const Vector3d& p, const Vector3d& low, double side) {
  constexpr int kBits = 20;
  std::uint64_t position = 0;
  for (int c = 0; c < 3; ++c) {
    const auto cell = static_cast<std::uint64_t>(((1 << kBits) - 1) * ((p[c] - low[c]) / side));
    for (int bit = 0; bit < kBits; ++bit) position |= (cell >> bit & 1U) << (3 * bit + c);
  }
  return position;
}

std::vector<int> NodesAlongCurve(const SurfaceMesh& surface) {
  const std::vector<bool> used = UsedNodes(surface.triangles, surface.nodes.size());
  Vector3d low = surface.nodes.front(), high = low;
  for (const auto& p : surface.nodes) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::vector<std::pair<std::uint64_t, int>> order;
  for (std::size_t n = 0; n < used.size(); ++n) {
    if (!used[n]) continue;
    order.emplace_back(CurvePosition(surface.nodes[n], low, (high - low).maxCoeff()),
                       static_cast<int>(n));
  }
  std::ranges::sort(order);
  std::vector<int> nodes;
  for (const auto& [position, node] : order) nodes.push_back(node);
  return nodes;
}

}  // namespace

GreenGroups::GreenGroups(const RestStiffness& stiffness)
    : stiffness_(stiffness),
      hash_(Hash().Add(kGroupsVersion).Add(kGroup).Add(stiffness.inputs).value()),
      node_of_place_(NodesAlongCurve(stiffness.elements.touch_surface)),
      place_of_node_(stiffness.elements.nodes.size(), -1) {
  for (int p = 0; p < places(); ++p) place_of_node_[Index(node_of_place_[Index(p)])] = p;
}

int GreenGroups::RowOf(int place, int component) const {
  return stiffness_.row[Index(node_of_place_[Index(place)])][Index(component)];
}

void GreenGroups::SetLoads(int group, Eigen::Ref<Eigen::MatrixXd> columns) const {
  columns.setZero();
  for (int j = 0; j < 3 * count(group); ++j) {
    const int loaded = RowOf(first(group) + j / 3, j % 3);
    if (loaded >= 0) columns(loaded, j) = 1;
  }
}

void GreenGroups::TakeSurface(int group, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                              std::span<double> values) const {
  for (int j = 0; j < 3 * count(group); ++j) {
    double* column = values.data() + per_place() * Index(j / 3) + 3 * (j % 3);
    const bool held = RowOf(first(group) + j / 3, j % 3) < 0;
    for (int p = 0; p < places(); ++p) {
      for (int r = 0; r < 3; ++r) {
        const int at = RowOf(p, r);
        column[9 * p + r] = at < 0 || held ? 0 : columns(at, j);
      }
    }
  }
}

}  // namespace palpate

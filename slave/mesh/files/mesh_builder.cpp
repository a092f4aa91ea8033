#include "slave/mesh/files/mesh_builder.h"

#include <algorithm>
#include <utility>

namespace palpate {
namespace {

// [m]; its cube and the ratios of its squares do not overflow.
constexpr double kMaxCoordinate = 1e15;

// Drops numbers that only count from 0.
std::vector<std::int64_t> UnlessPlain(std::vector<std::int64_t> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] != static_cast<std::int64_t>(i)) return numbers;
  }
  return {};
}

}  // namespace

const CellKind* FindKind(std::span<const CellKind> kinds, std::int64_t code) {
  const auto found = std::ranges::find(kinds, code, &CellKind::code);
  return found == kinds.end() ? nullptr : &*found;
}

void MeshBuilder::ReserveNodes(std::size_t count) {
  mesh_nodes_.reserve(count);
  node_numbers_.reserve(count);
}

void MeshBuilder::AddNode(std::int64_t number, const Eigen::Vector3d& p) {
  if (consecutive_ && !node_numbers_.empty() && number != node_numbers_.back() + 1) {
    consecutive_ = false;
    for (std::size_t i = 0; i < node_numbers_.size(); ++i) {
      node_index_.emplace(node_numbers_[i], static_cast<int>(i));
    }
  }
  if (!consecutive_ && !node_index_.emplace(number, static_cast<int>(node_count())).second) {
    place_->Refuse("node " + std::to_string(number) + " again", "every number once");
  }
  mesh_nodes_.push_back(p);
  node_numbers_.push_back(number);
}

int MeshBuilder::IndexOf(std::int64_t number) const {
  if (!consecutive_) {
    if (const auto found = node_index_.find(number); found != node_index_.end()) {
      return found->second;
    }
  } else if (!node_numbers_.empty() && number >= node_numbers_.front() &&
             number <= node_numbers_.back()) {
    return static_cast<int>(number - node_numbers_.front());
  }
  std::string accepted = "a node of the file";
  if (!node_numbers_.empty()) {
    const auto [low, high] = std::ranges::minmax(node_numbers_);
    accepted += ", from " + std::to_string(low) + " to " + std::to_string(high);
  }
  place_->Refuse("node " + std::to_string(number), accepted);
}

void MeshBuilder::UseCorners(std::span<const int> corners) {
  for (const int i : corners) roles_[static_cast<std::size_t>(i)] = Role::kCorner;
}

void MeshBuilder::AddQuad(std::int64_t number, const std::array<int, 4>& corners) {
  const auto [a, b, c, d] = corners;
  const auto p = [&](int i) { return mesh_nodes_[static_cast<std::size_t>(i)]; };
  ++quads_;
  if ((p(c) - p(a)).norm() <= (p(d) - p(b)).norm()) {
    triangles_.insert(triangles_.end(), {{a, b, c}, {a, c, d}});
  } else {
    triangles_.insert(triangles_.end(), {{a, b, d}, {b, c, d}});
  }
  triangle_numbers_.insert(triangle_numbers_.end(), 2, number);
}

void MeshBuilder::AddCell(const CellKind& kind, std::int64_t number,
                          std::span<const std::int64_t> nodes) {
  using enum CellKind::Use;
  if (kind.use == kPassedOver) return;
  if (kind.use == kRefused) {
    place_->Refuse("element " + std::to_string(number) + " is a " + std::string(kind.name),
                   "tetrahedra, or triangles for a surface");
  }
  roles_.resize(node_count(), Role::kNone);
  const std::size_t corner_count = kind.use == kTriangle ? 3 : 4;
  std::array<int, 4> corners{};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const int index = IndexOf(nodes[i]);
    if (i < corner_count) {
      corners[i] = index;
    } else if (Role& role = roles_[static_cast<std::size_t>(index)]; role == Role::kNone) {
      role = Role::kMiddle;
    }
  }
  UseCorners(std::span(corners).first(corner_count));
  if (kind.use == kTet) {
    tets_.push_back(corners);
    tet_numbers_.push_back(number);
  } else if (kind.use == kTriangle) {
    triangles_.push_back({corners[0], corners[1], corners[2]});
    triangle_numbers_.push_back(number);
  } else {
    AddQuad(number, corners);
  }
}

void MeshBuilder::DropMiddles(std::vector<std::array<int, 4>>* tets,
                              std::vector<std::array<int, 3>>* triangles) {
  const auto dropped = std::ranges::count(roles_, Role::kMiddle);
  if (dropped == 0) return;
  roles_.resize(node_count(), Role::kNone);
  std::vector<int> renumbered(node_count());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < node_count(); ++i) {
    renumbered[i] = static_cast<int>(kept);
    if (roles_[i] == Role::kMiddle) continue;
    mesh_nodes_[kept] = mesh_nodes_[i];
    node_numbers_[kept++] = node_numbers_[i];
  }
  mesh_nodes_.resize(kept);
  node_numbers_.resize(kept);
  for (auto& tet : *tets) {
    for (int& i : tet) i = renumbered[static_cast<std::size_t>(i)];
  }
  for (auto& triangle : *triangles) {
    for (int& i : triangle) i = renumbered[static_cast<std::size_t>(i)];
  }
  Remark("quadratic elements: their corners are used, " + std::to_string(dropped) +
         " nodes in the middle of edges are not");
}

void MeshBuilder::RequireNear(double largest) const {
  if (largest <= kMaxCoordinate) return;
  place_->Refuse("a coordinate of " + Brief(largest) + " m",
                 "at most " + Brief(kMaxCoordinate) + " m");
}

MeshFile MeshBuilder::Finish(double unit) {
  if (tets_.empty() && triangles_.empty()) {
    place_->Refuse("no element was found", "tetrahedra, or triangles for a surface");
  }
  DropMiddles(&tets_, &triangles_);
  for (auto& p : mesh_nodes_) {
    p *= unit;
    RequireNear(p.cwiseAbs().maxCoeff());
  }
  MeshFile file;
  file.numbers.nodes = UnlessPlain(std::move(node_numbers_));
  if (!tets_.empty()) {
    file.mesh = SolidMesh{std::move(mesh_nodes_), std::move(tets_)};
    file.numbers.elements = UnlessPlain(std::move(tet_numbers_));
  } else {
    if (quads_ > 0) Remark(std::to_string(quads_) + " quadrilaterals: each cut into two triangles");
    file.mesh = SurfaceMesh{std::move(mesh_nodes_), std::move(triangles_)};
    file.numbers.elements = UnlessPlain(std::move(triangle_numbers_));
  }
  file.remarks = std::move(remarks_);
  return file;
}

}  // namespace palpate

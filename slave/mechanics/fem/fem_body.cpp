#include "slave/mechanics/fem/fem_body.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "slave/mechanics/linear/elimination_order.h"
#include "slave/mechanics/linear/lanes.h"
#include "slave/mesh/index.h"
#include "slave/mesh/mesh_census.h"

namespace palpate::fem {
namespace {

constexpr std::size_t kMaxElements = 4'000'000;
constexpr std::size_t kRotationsPerNode = 4;

void Check(const SolidMesh& mesh, const HeldNodes& held) {
  RequireTets(mesh, held);
  if (mesh.tets.size() <= kMaxElements) return;
  throw std::invalid_argument("elements = " + std::to_string(mesh.tets.size()) +
                              ": expected 1 to " + std::to_string(kMaxElements));
}

// Coordinates from the box's corner, so that a body far from the origin keeps its digits.
std::vector<Eigen::Vector3d> Scaled(const SolidMesh& mesh, double unit) {
  const Eigen::Vector3d origin = mesh.nodes.front();
  std::vector<Eigen::Vector3d> points;
  for (const auto& p : mesh.nodes) points.push_back((p - origin) / unit);
  return points;
}

NodeGraph GraphOf(int rows, const std::vector<std::array<int, 4>>& tets) {
  std::vector<int> count(Index(rows) + 1, 0);
  const auto for_pairs = [&](const auto& action) {
    for (const auto& tet : tets) {
      for (const int i : tet) {
        for (const int j : tet) {
          if (i < rows && j < rows) action(i, j);
        }
      }
    }
  };
  for_pairs([&](int i, int) { ++count[Index(i) + 1]; });
  std::partial_sum(count.begin(), count.end(), count.begin());
  std::vector<int> all(Index(count.back()));
  std::vector<int> next(count.begin(), count.end() - 1);
  for_pairs([&](int i, int j) { all[Index(next[Index(i)]++)] = j; });
  NodeGraph graph{{0}, {}};
  for (int i = 0; i < rows; ++i) {
    const auto first = all.begin() + count[Index(i)], last = all.begin() + count[Index(i) + 1];
    std::sort(first, last);
    graph.column.insert(graph.column.end(), first, std::unique(first, last));
    graph.begin.push_back(static_cast<int>(graph.column.size()));
  }
  return graph;
}

std::vector<int> OrderOf(const NodeGraph& graph) {
  std::vector<std::vector<int>> neighbours;
  for (int i = 0; i < graph.size(); ++i) {
    neighbours.emplace_back(graph.of(i).begin(), graph.of(i).end());
  }
  return EliminationOrder(neighbours);
}

std::vector<std::array<int, 4>> Renumbered(const std::vector<std::array<int, 4>>& tets,
                                           const std::vector<int>& number) {
  auto result = tets;
  for (auto& tet : result) {
    for (int& node : tet) node = number[Index(node)];
  }
  return result;
}

std::vector<double> Renumbered(const std::vector<double>& moduli, const std::vector<int>& order) {
  std::vector<double> result;
  for (const int element : order) {
    if (!moduli.empty()) result.push_back(moduli[Index(element)]);
  }
  return result;
}

struct Stencil {
  const int* begin;
  const int* block;
  const int* transpose;
  const double *mass, *isotropic;
  double mass_factor, stiffness_factor, ratio;  // ratio = lambda / mu
};

using Double2 [[gnu::vector_size(16), gnu::may_alias, gnu::aligned(8)]] = double;

PALPATE_INLINE void StoreThree(double* p, const Double4& v) {
  *reinterpret_cast<Double2*>(p) = Double2{v[0], v[1]};
  p[2] = v[2];
}

// block = stiffness (ratio X + X^T) + (mass m + stiffness d) I, X = sum of q_a q_b^T.
PALPATE_DISPATCHED void AssembleBlocks(const Stencil& s, const int* corners, const NodeValue* q,
                                       double* values, int count) {
  for (int u = 0; u < count; ++u) {
    Double4 x0{}, x1{}, x2{};
    for (int c = s.begin[u]; c < s.begin[u + 1]; ++c) {
      const Double4 a = Load4(q[corners[2 * c]].v);
      const double* b = q[corners[2 * c + 1]].v;
      x0 += a * b[0];
      x1 += a * b[1];
      x2 += a * b[2];
    }
    const int k = s.block[u];
    const double diagonal = s.mass_factor * s.mass[k] + s.stiffness_factor * s.isotropic[k];
    const Double4 rows[3] = {
        {x0[0], x1[0], x2[0], 0}, {x0[1], x1[1], x2[1], 0}, {x0[2], x1[2], x2[2], 0}};
    const Double4 columns[3] = {x0, x1, x2};
    const Double4 unit[3] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    double* block = values + 9 * static_cast<std::ptrdiff_t>(k);
    double* mirror = values + 9 * static_cast<std::ptrdiff_t>(s.transpose[k]);
    for (int c = 0; c < 3; ++c) {
      StoreThree(block + 3 * c,
                 s.stiffness_factor * (s.ratio * columns[c] + rows[c]) + diagonal * unit[c]);
      StoreThree(mirror + 3 * c,
                 s.stiffness_factor * (s.ratio * rows[c] + columns[c]) + diagonal * unit[c]);
    }
  }
}

PALPATE_DISPATCHED void GatherForces(const int* begin, const int* touching,
                                     const NodeValue* corner_forces, NodeValue* f, int count) {
  for (int i = 0; i < count; ++i) {
    Double4 sum{};
    for (int t = begin[i]; t < begin[i + 1]; ++t) sum += Load4(corner_forces[touching[t]].v);
    Store4(f[i].v, sum);
  }
}

}  // namespace

FemBody::FemBody(const SolidMesh& mesh, const HeldNodes& held, const Params& params)
    : length_unit_((Check(mesh, held), LargerSide(mesh.nodes))),
      points_(Scaled(mesh, length_unit_)),
      tets_((Number(mesh, held), Renumbered(mesh.tets, number_))),
      elements_(
          (SortElements(), SolidMesh{points_, tets_, Renumbered(mesh.modulus, mesh_element_)}),
          LameOf(params.poisson_ratio), params.law) {
  pattern_ = MakePattern(GraphOf(moving_, tets_));
  part_ = PartsOf(tets_, points_.size(), &parts_);
  FindContributions();
  if (params.law == TetElements::Law::kNeoHookean) FindPairs();
}

// The nodes that can move in the order of elimination, then the others.
void FemBody::Number(const SolidMesh& mesh, const HeldNodes& held) {
  const std::size_t count = mesh.nodes.size();
  const std::vector<bool> used = UsedNodes(mesh.tets, count);
  const auto fixed = [&](std::size_t i) {
    return !used[i] || (held[i][0] && held[i][1] && held[i][2]);
  };
  std::vector<int> moving, first_number(count, static_cast<int>(count));
  for (std::size_t i = 0; i < count; ++i) {
    if (fixed(i)) continue;
    first_number[i] = static_cast<int>(moving.size());
    moving.push_back(static_cast<int>(i));
  }
  moving_ = static_cast<int>(moving.size());
  std::vector<int> mesh_node;
  for (const int i : OrderOf(GraphOf(moving_, Renumbered(mesh.tets, first_number)))) {
    mesh_node.push_back(moving[Index(i)]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (fixed(i)) mesh_node.push_back(static_cast<int>(i));
  }
  number_.resize(count);
  free_.resize(count);
  const auto unordered = points_;
  for (std::size_t i = 0; i < count; ++i) {
    const auto old = Index(mesh_node[i]);
    number_[old] = static_cast<int>(i);
    points_[i] = unordered[old];
    for (std::size_t c = 0; c < 3; ++c) free_[i].v[c] = used[old] && !held[old][c] ? 1 : 0;
  }
}

// Sorts elements by their first node to be eliminated, so that neighbours in memory are neighbours
// in space.
void FemBody::SortElements() {
  mesh_element_.resize(tets_.size());
  std::iota(mesh_element_.begin(), mesh_element_.end(), 0);
  const auto first_node = [&](int e) {
    return *std::min_element(tets_[Index(e)].begin(), tets_[Index(e)].end());
  };
  std::stable_sort(mesh_element_.begin(), mesh_element_.end(),
                   [&](int a, int b) { return first_node(a) < first_node(b); });
  const auto unsorted = tets_;
  for (std::size_t e = 0; e < tets_.size(); ++e) {
    tets_[e] = unsorted[Index(mesh_element_[e])];
    std::ranges::sort(tets_[e]);  // blocks between corners are those above the diagonal
  }
}

void FemBody::FindContributions() {
  const std::size_t blocks = Index(pattern_.blocks());
  std::vector<int> upper_of(blocks, -1);
  for (int i = 0; i < moving(); ++i) {
    for (int k = pattern_.diagonal[Index(i)]; k < pattern_.graph.begin[Index(i) + 1]; ++k) {
      upper_of[Index(k)] = static_cast<int>(upper_.size());
      upper_.push_back(k);
    }
  }
  mass_.assign(blocks, 0);
  isotropic_.assign(blocks, 0);
  volume_.assign(points_.size(), 0);
  const NodeVector& q = elements_.corner_gradients();
  std::vector<std::array<int, 3>> found;  // upper block, corners
  for (int e = 0; e < element_count(); ++e) {
    const auto& tet = tets_[Index(e)];
    const double volume = std::abs(GeometryOf(points_, tet).volume);
    for (int a = 0; a < 4; ++a) {
      const int i = tet[Index(a)];
      volume_[Index(i)] += volume / 4;
      if (i >= moving()) continue;
      for (int b = 0; b < 4; ++b) {
        const int j = tet[Index(b)];
        if (j >= moving()) continue;
        const int k = pattern_.Find(i, j);
        const double share = a == b ? 0.1 : 0.05;
        mass_[Index(k)] += share * volume;
        const auto *qa = At(q, 4 * e + a).v, *qb = At(q, 4 * e + b).v;
        isotropic_[Index(k)] += qa[0] * qb[0] + qa[1] * qb[1] + qa[2] * qb[2];
        if (upper_of[Index(k)] >= 0) found.push_back({upper_of[Index(k)], 4 * e + a, 4 * e + b});
      }
    }
  }
  corners_begin_.assign(upper_.size() + 1, 0);
  for (const auto& f : found) ++corners_begin_[Index(f[0]) + 1];
  std::partial_sum(corners_begin_.begin(), corners_begin_.end(), corners_begin_.begin());
  std::vector<int> next(corners_begin_.begin(), corners_begin_.end() - 1);
  corners_.resize(2 * found.size());
  for (const auto& f : found) {
    const auto at = 2 * Index(next[Index(f[0])]++);
    corners_[at] = f[1];
    corners_[at + 1] = f[2];
  }
  FindTouching();
}

void FemBody::FindTouching() {
  touching_.begin.assign(points_.size() + 1, 0);
  for (const auto& tet : tets_) {
    for (const int node : tet) ++touching_.begin[Index(node) + 1];
  }
  std::partial_sum(touching_.begin.begin(), touching_.begin.end(), touching_.begin.begin());
  std::vector<int> next(touching_.begin.begin(), touching_.begin.end() - 1);
  touching_.column.resize(4 * tets_.size());
  for (int c = 0; c < 4 * element_count(); ++c) {
    touching_.column[Index(next[Index(tets_[Index(c / 4)][Index(c % 4)])]++)] = c;
  }
}

// Blocks with a fixed node are redirected to a dummy block after the last one.
void FemBody::FindPairs() {
  TetElements::GroupBlocks none;
  for (auto& pair : none) pair.fill(pattern_.blocks());
  pairs_.assign(Index(elements_.groups()), none);
  for (int e = 0; e < element_count(); ++e) {
    const auto& tet = tets_[Index(e)];
    std::size_t pair = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a; b < 4; ++b, ++pair) {
        if (tet[b] >= moving()) continue;
        pairs_[Index(e / kLanes)][pair][Index(e % kLanes)] = pattern_.Find(tet[a], tet[b]);
      }
    }
  }
}

ElementSummary FemBody::EvaluateWithTangent(const NodeVector& u, double shift,
                                            BlockMatrix& tangent) noexcept {
  if (elements_.law() != TetElements::Law::kNeoHookean) {
    const ElementSummary summary = Evaluate(u);
    AssembleTangent(0, 1, tangent);
    return summary;
  }
  for (int i = 0; i < moving(); ++i) {
    std::fill(tangent.block(pattern_.diagonal[Index(i)]),
              tangent.block(pattern_.graph.begin[Index(i) + 1]), 0.0);
  }
  const ElementSummary summary =
      elements_.EvaluateWithTangent(u, pairs_, {tangent.block(0), shift});
  MirrorUpper(tangent);
  return summary;
}

void FemBody::MirrorUpper(BlockMatrix& matrix) noexcept {
  for (int i = 0; i < moving(); ++i) {
    for (int k = pattern_.diagonal[Index(i)] + 1; k < pattern_.graph.begin[Index(i) + 1]; ++k) {
      const double* from = matrix.block(k);
      double* to = matrix.block(pattern_.transpose[Index(k)]);
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) to[3 * r + c] = from[3 * c + r];
      }
    }
  }
}

void FemBody::InternalForce(NodeVector& f) noexcept {
  GatherForces(touching_.begin.data(), touching_.column.data(), elements_.corner_forces().data(),
               f.data(), size());
}

void FemBody::AssembleTangent(double mass, double stiffness, BlockMatrix& matrix) noexcept {
  const Stencil stencil{corners_begin_.data(),
                        upper_.data(),
                        pattern_.transpose.data(),
                        mass_.data(),
                        isotropic_.data(),
                        mass,
                        stiffness,
                        elements_.lame().lambda / elements_.lame().mu};
  AssembleBlocks(stencil, corners_.data(), elements_.corner_gradients().data(), matrix.block(0),
                 static_cast<int>(upper_.size()));
}

void FemBody::NodeRotations(NodeVector& rotations) const noexcept {
  for (int i = 0; i < moving(); ++i) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    const auto corners = touching_.of(i);
    const std::size_t stride = std::max<std::size_t>(1, corners.size() / kRotationsPerNode);
    for (std::size_t k = 0; k < corners.size(); k += stride) {
      const NodeValue rotation = elements_.Rotation(corners[k] / 4);
      const Eigen::Map<const Eigen::Vector4d> q(rotation.v);
      sum += q * (q.dot(sum) < 0 ? -1 : 1);  // q and -q are the same rotation
    }
    Eigen::Map<Eigen::Vector4d>(At(rotations, i).v) = sum.normalized();
  }
}

std::size_t FemBody::memory_bytes() const {
  return elements_.memory_bytes() + sizeof(int) * (corners_.size() + touching_.column.size()) +
         pattern_.graph.column.size() * (2 * sizeof(int) + 2 * sizeof(double));
}

}  // namespace palpate::fem

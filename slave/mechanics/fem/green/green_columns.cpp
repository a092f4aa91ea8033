#include "slave/mechanics/fem/green/green_columns.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "shared/geometry/index.h"
#include "shared/mesh/mesh_census.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kVersion = 1;  // of what is kept on disk

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

std::uint64_t HashOf(const TetStiffness& stiffness, const std::vector<int>& node_of_place) {
  const auto& K = stiffness.lower;
  const auto entries = static_cast<std::size_t>(K.nonZeros());
  Hash hash;
  hash.Add(kVersion).Add(GreenColumns::kGroup).Add(K.rows()).Add(entries);
  hash.Add(std::as_bytes(std::span(K.valuePtr(), entries)));
  hash.Add(std::as_bytes(std::span(K.innerIndexPtr(), entries)));
  hash.Add(std::as_bytes(std::span(node_of_place)));
  for (const auto& rows : stiffness.row) hash.Add(rows);
  return hash.value();
}

// Nested dissection of a block-like mesh: operations grow with n^2, entries with n^(4/3).
PrecomputeCost ExpectedCost(int order) {
  const double n = order / 57000.0;
  const auto bytes = static_cast<std::size_t>(5e8 * std::pow(n, 4.0 / 3));
  return {2.5 * n * n + 0.3 * n, bytes};
}

}  // namespace

GreenColumns::GreenColumns(TetStiffness stiffness, const SurfaceMesh& surface,
                           std::size_t memory_limit, const std::filesystem::path& cache,
                           Progress* progress)
    : stiffness_(std::move(stiffness)),
      node_of_place_(NodesAlongCurve(surface)),
      place_of_node_(surface.nodes.size(), -1),
      memory_limit_(memory_limit) {
  for (int p = 0; p < places(); ++p) place_of_node_[Index(node_of_place_[Index(p)])] = p;
  column_of_place_.assign(node_of_place_.size(), nullptr);
  groups_.resize((node_of_place_.size() + kGroup - 1) / kGroup);
  if (!cache.empty()) cache_ = ColumnCache(cache, HashOf(stiffness_, node_of_place_));
  bool all_kept = cache_.enabled();
  for (int g = 0; g < static_cast<int>(groups_.size()) && all_kept; ++g) all_kept = cache_.Has(g);
  if (all_kept) return;
  if (progress != nullptr) progress->Expect(ExpectedCost(order()));
  ReportProgress(progress, "factorising stiffness", 0);
  Factor();
  ReportProgress(progress, "factorising stiffness", 1);
}

SpdFactor& GreenColumns::Factor() {
  if (!factor_) factor_.emplace(stiffness_.lower);
  return *factor_;
}

std::size_t GreenColumns::memory_bytes() const {
  const auto stiffness = static_cast<std::size_t>(stiffness_.lower.nonZeros()) * 12;
  return column_bytes_ + stiffness + (factor_ ? factor_->memory_bytes() : 0);
}

const double* GreenColumns::Compute(int place) {
  const int group = place / kGroup;
  const int first = group * kGroup;
  const int count = std::min(kGroup, places() - first);
  const std::size_t per_place = 9 * node_of_place_.size();
  const std::size_t bytes = bytes_per_place() * Index(count);
  if (column_bytes_ + bytes > memory_limit_) return nullptr;
  auto values = std::make_unique<double[]>(per_place * Index(count));
  const std::span view(values.get(), per_place * Index(count));
  if (!cache_.Load(group, view)) {
    ComputeGroup(group, view);
    cache_.Save(group, view);
  }
  column_bytes_ += bytes;
  groups_[Index(group)] = std::move(values);
  for (int k = 0; k < count; ++k) {
    column_of_place_[Index(first + k)] = view.data() + per_place * Index(k);
  }
  return column_of_place_[Index(place)];
}

void GreenColumns::ComputeGroup(int group, std::span<double> values) {
  const int first = group * kGroup;
  const int count = static_cast<int>(values.size() / (9 * node_of_place_.size()));
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(order(), 3 * kGroup);
  const auto row = [&](int place, int c) {
    return stiffness_.row[Index(node_of_place_[Index(place)])][Index(c)];
  };
  for (int j = 0; j < 3 * count; ++j) {
    const int loaded = row(first + j / 3, j % 3);
    if (loaded >= 0) columns(loaded, j) = 1;
  }
  Factor().Solve(columns.data(), 3 * kGroup);
  for (int j = 0; j < 3 * count; ++j) {
    double* column = values.data() + 9 * Index(j / 3) * node_of_place_.size() + 3 * (j % 3);
    const bool held = row(first + j / 3, j % 3) < 0;
    for (int p = 0; p < places(); ++p) {
      for (int r = 0; r < 3; ++r) {
        const int at = row(p, r);
        column[9 * p + r] = at < 0 || held ? 0 : columns(at, j);
      }
    }
  }
  ++groups_computed_;
}

bool GreenColumns::Prefetch(std::span<const int> places, Progress* progress) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (IsReady(places[i])) continue;
    const double done = static_cast<double>(i) / static_cast<double>(places.size());
    ReportProgress(progress, "Green's functions", done);
    if (Column(places[i]) == nullptr) return false;
  }
  ReportProgress(progress, "Green's functions", 1);
  return true;
}

void GreenColumns::Solve(std::span<const int> places, std::span<const Vector3d> forces,
                         std::vector<Vector3d>* displacement) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(order());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& row = stiffness_.row[Index(node_of_place_[Index(places[i])])];
    for (int c = 0; c < 3; ++c) {
      if (row[Index(c)] >= 0) x[row[Index(c)]] += forces[i][c];
    }
  }
  Factor().Solve(x.data(), 1);
  Spread(x, displacement);
}

void GreenColumns::SolveAxes(std::span<const int> places,
                             std::array<std::vector<Vector3d>, 3>* displacement) {
  Eigen::MatrixX3d x = Eigen::MatrixX3d::Zero(order(), 3);
  for (const int place : places) {
    const auto& row = stiffness_.row[Index(node_of_place_[Index(place)])];
    for (int c = 0; c < 3; ++c) {
      if (row[Index(c)] >= 0) x(row[Index(c)], c) += 1 / static_cast<double>(places.size());
    }
  }
  Factor().Solve(x.data(), 3);
  for (int c = 0; c < 3; ++c) Spread(x.col(c), &(*displacement)[Index(c)]);
}

void GreenColumns::Spread(const Eigen::Ref<const Eigen::VectorXd>& x,
                          std::vector<Vector3d>* u) const {
  u->assign(stiffness_.row.size(), Vector3d::Zero());
  for (std::size_t n = 0; n < u->size(); ++n) {
    for (int c = 0; c < 3; ++c) {
      const int row = stiffness_.row[n][Index(c)];
      if (row >= 0) (*u)[n][c] = x[row];
    }
  }
}

}  // namespace palpate

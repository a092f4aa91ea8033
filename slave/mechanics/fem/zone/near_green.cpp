#include "slave/mechanics/fem/zone/near_green.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::Vector3d;

constexpr std::size_t kVersion = 1;  // of what is kept on disk
constexpr double kStep = 1.2;        // from one reach to the next
constexpr int kAnchors = 512;        // of the body

// Along Morton's curve, so that neighbours have near numbers.
std::vector<int> OrderAlongCurve(const std::vector<Vector3d>& positions) {
  Vector3d low = positions.front(), high = low;
  for (const auto& p : positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double side = (high - low).maxCoeff();
  std::vector<std::pair<std::uint64_t, int>> order;
  for (std::size_t n = 0; n < positions.size(); ++n) {
    constexpr unsigned kBits = 20;
    std::uint64_t at = 0;
    for (unsigned c = 0; c < 3; ++c) {
      const auto axis = static_cast<int>(c);
      const auto cell = static_cast<std::uint64_t>(((1U << kBits) - 1) *
                                                   ((positions[n][axis] - low[axis]) / side));
      for (unsigned bit = 0; bit < kBits; ++bit) at |= (cell >> bit & 1U) << (3 * bit + c);
    }
    order.emplace_back(at, static_cast<int>(n));
  }
  std::ranges::sort(order);
  std::vector<int> nodes;
  for (const auto& [at, node] : order) nodes.push_back(node);
  return nodes;
}

}  // namespace

void SpreadNodes(const std::vector<Vector3d>& positions, std::span<const int> from, int count,
                 std::vector<int>* chosen) {
  std::vector<double> distance(from.size(), std::numeric_limits<double>::infinity());
  const auto come_nearer = [&](int node) {
    const Vector3d& p = positions[Index(node)];
    for (std::size_t i = 0; i < from.size(); ++i) {
      distance[i] = std::min(distance[i], (positions[Index(from[i])] - p).squaredNorm());
    }
  };
  for (const int node : *chosen) come_nearer(node);
  while (!from.empty() && static_cast<int>(chosen->size()) < count) {
    const auto next =
        static_cast<std::size_t>(std::ranges::max_element(distance) - distance.begin());
    if (!(distance[next] > 0)) break;
    chosen->push_back(from[next]);
    come_nearer(from[next]);
  }
}

NearGreen::NearGreen(const SolidMesh& mesh, const HeldNodes& held, double nu,
                     std::size_t memory_limit, const std::filesystem::path& cache)
    : stiffness_(AssembleTetStiffness(mesh, held, nu, TetElement::kTet4)),
      factor_(stiffness_.lower),
      columns_(mesh.nodes.size()),
      number_(mesh.nodes.size(), -1),
      memory_limit_(memory_limit),
      cache_(cache) {
  for (const auto& p : mesh.nodes) positions_.push_back(p / length_unit());
  order_ = OrderAlongCurve(positions_);
  group_of_.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) {
    group_of_[Index(order_[i])] = static_cast<int>(i) / kGroup;
  }
  std::vector<int> all(mesh.nodes.size());
  std::iota(all.begin(), all.end(), 0);
  SpreadNodes(positions_, all, kAnchors, &anchors_);
}

std::size_t NearGreen::memory_bytes() const {
  return factor_.memory_bytes() + static_cast<std::size_t>(stiffness_.lower.nonZeros()) * 12 +
         column_bytes_;
}

MatrixXd NearGreen::Solve(const MatrixXd& forces) {
  MatrixXd x(stiffness_.lower.rows(), forces.cols());
  const auto nodes = static_cast<int>(positions_.size());
  for (int n = 0; n < nodes; ++n) {
    for (int c = 0; c < 3; ++c) {
      if (Row(n, c) >= 0) x.row(Row(n, c)) = forces.row(3 * n + c);
    }
  }
  if (x.cols() > 0) factor_.Solve(x.data(), static_cast<int>(x.cols()));
  MatrixXd u = MatrixXd::Zero(forces.rows(), forces.cols());
  for (int n = 0; n < nodes; ++n) {
    for (int c = 0; c < 3; ++c) {
      if (Row(n, c) >= 0) u.row(3 * n + c) = x.row(Row(n, c));
    }
  }
  return u;
}

bool NearGreen::Prepare(std::span<const int> nodes, double least, Progress* progress) {
  const double reach = std::pow(kStep, std::ceil(std::log(least) / std::log(kStep)));
  std::vector<int> groups;
  for (const int node : nodes) {
    if (!IsReady(node, least)) groups.push_back(group_of_[Index(node)]);
  }
  std::ranges::sort(groups);
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    ReportProgress(progress, "Green's functions",
                   static_cast<double>(i) / static_cast<double>(groups.size()));
    if (column_bytes_ > memory_limit_) return false;
    const std::size_t before = GroupBytes(groups[i]);
    ComputeGroup(groups[i], reach);
    column_bytes_ += GroupBytes(groups[i]) - before;
  }
  if (!groups.empty()) ReportProgress(progress, "Green's functions", 1);
  return true;
}

void NearGreen::FindNodes(int group, double reach) {
  const std::size_t first = Index(group) * kGroup;
  for (std::size_t i = first; i < std::min(first + kGroup, order_.size()); ++i) {
    Column& column = columns_[Index(order_[i])];
    column.nodes.clear();
    const Vector3d& p = positions_[Index(order_[i])];
    for (std::size_t n = 0; n < positions_.size(); ++n) {
      if ((positions_[n] - p).squaredNorm() <= reach * reach) {
        column.nodes.push_back(static_cast<int>(n));
      }
    }
    column.blocks.resize(9 * column.nodes.size());
    column.anchors.resize(9 * anchors_.size());
  }
}

void NearGreen::ComputeGroup(int group, double reach) {
  FindNodes(group, reach);
  const std::size_t first = Index(group) * kGroup;
  const std::size_t end = std::min(first + kGroup, order_.size());
  if (!LoadGroup(group, reach)) {
    MatrixXd x = MatrixXd::Zero(stiffness_.lower.rows(), 3L * kGroup);
    for (std::size_t i = first; i < end; ++i) {
      for (int c = 0; c < 3; ++c) {
        const int row = Row(order_[i], c);
        if (row >= 0) x(row, 3 * static_cast<int>(i - first) + c) = 1;
      }
    }
    factor_.Solve(x.data(), static_cast<int>(x.cols()));
    columns_solved_ += static_cast<int>(x.cols());
    for (std::size_t i = first; i < end; ++i) Take(x, static_cast<int>(i - first), order_[i]);
    SaveGroup(group, reach);
  }
  for (std::size_t i = first; i < end; ++i) columns_[Index(order_[i])].reach = reach;
}

void NearGreen::Take(const MatrixXd& x, int in_group, int node) {
  Column& column = columns_[Index(node)];
  const auto take = [&](int at, float* block) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        const int row = Row(at, r);
        block[3 * c + r] = row < 0 ? 0.0F : static_cast<float>(x(row, 3 * in_group + c));
      }
    }
  };
  for (std::size_t k = 0; k < column.nodes.size(); ++k)
    take(column.nodes[k], &column.blocks[9 * k]);
  for (std::size_t k = 0; k < anchors_.size(); ++k) take(anchors_[k], &column.anchors[9 * k]);
}

ColumnCache NearGreen::CacheFor(double reach) const {
  return {cache_,
          Hash().Add(kVersion).Add(kGroup).Add(kAnchors).Add(stiffness_.inputs).Add(reach).value()};
}

std::size_t NearGreen::GroupBytes(int group) const {
  std::size_t numbers = 0;
  const std::size_t first = Index(group) * kGroup;
  for (std::size_t i = first; i < std::min(first + kGroup, order_.size()); ++i) {
    const Column& column = columns_[Index(order_[i])];
    numbers += column.nodes.size() + column.blocks.size() + column.anchors.size();
  }
  return sizeof(float) * numbers;
}

// Two numbers in the place of one double.
bool NearGreen::LoadGroup(int group, double reach) {
  if (cache_.empty()) return false;
  const std::size_t first = Index(group) * kGroup, end = std::min(first + kGroup, order_.size());
  std::size_t count = 0;
  for (std::size_t i = first; i < end; ++i) {
    count += columns_[Index(order_[i])].blocks.size() + 9 * anchors_.size();
  }
  std::vector<double> values((count + 1) / 2);
  if (!CacheFor(reach).Load(group, values)) return false;
  const auto* from = reinterpret_cast<const std::byte*>(values.data());
  for (std::size_t i = first; i < end; ++i) {
    Column& column = columns_[Index(order_[i])];
    for (std::vector<float>* part : {&column.blocks, &column.anchors}) {
      std::memcpy(part->data(), from, sizeof(float) * part->size());
      from += sizeof(float) * part->size();
    }
  }
  return true;
}

void NearGreen::SaveGroup(int group, double reach) const {
  if (cache_.empty()) return;
  const std::size_t first = Index(group) * kGroup, end = std::min(first + kGroup, order_.size());
  std::vector<float> numbers;
  for (std::size_t i = first; i < end; ++i) {
    const Column& column = columns_[Index(order_[i])];
    numbers.insert(numbers.end(), column.blocks.begin(), column.blocks.end());
    numbers.insert(numbers.end(), column.anchors.begin(), column.anchors.end());
  }
  std::vector<double> values((numbers.size() + 1) / 2, 0);
  std::memcpy(values.data(), numbers.data(), sizeof(float) * numbers.size());
  CacheFor(reach).Save(group, values);
}

bool NearGreen::Gather(std::span<const int> to, std::span<const int> from, MatrixXf* G,
                       std::vector<std::array<int, 2>>* missed) {
  G->setZero(3 * static_cast<int>(to.size()), 3 * static_cast<int>(from.size()));
  for (std::size_t i = 0; i < to.size(); ++i) number_[Index(to[i])] = static_cast<int>(i);
  bool complete = true;
  std::vector<char> found(to.size());
  for (std::size_t j = 0; j < from.size(); ++j) {
    const Column& column = columns_[Index(from[j])];
    std::ranges::fill(found, char{0});
    for (std::size_t k = 0; k < column.nodes.size(); ++k) {
      const int i = number_[Index(column.nodes[k])];
      if (i < 0) continue;
      found[Index(i)] = 1;
      const float* block = &column.blocks[9 * k];
      for (int c = 0; c < 3; ++c) {
        float* target = G->data() + (3 * static_cast<int>(j) + c) * G->rows() + 3 * i;
        for (int r = 0; r < 3; ++r) target[r] = block[3 * c + r];
      }
    }
    for (std::size_t i = 0; i < to.size(); ++i) {
      if (found[i] != 0) continue;
      complete = false;
      if (missed != nullptr) missed->push_back({static_cast<int>(i), static_cast<int>(j)});
    }
  }
  for (const int node : to) number_[Index(node)] = -1;
  return complete;
}

bool NearGreen::GatherAtAnchors(std::span<const int> anchors, std::span<const int> from,
                                MatrixXf* G) {
  G->setZero(3 * static_cast<int>(anchors.size()), 3 * static_cast<int>(from.size()));
  bool complete = true;
  for (std::size_t j = 0; j < from.size(); ++j) {
    const Column& column = columns_[Index(from[j])];
    complete = complete && column.reach > 0;
    if (!(column.reach > 0)) continue;
    for (std::size_t i = 0; i < anchors.size(); ++i) {
      const Eigen::Map<const Eigen::Matrix3f> block(&column.anchors[9 * Index(anchors[i])]);
      G->block<3, 3>(3 * static_cast<int>(i), 3 * static_cast<int>(j)) = block;
    }
  }
  return complete;
}

}  // namespace palpate

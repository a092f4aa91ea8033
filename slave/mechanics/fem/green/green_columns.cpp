#include "slave/mechanics/fem/green/green_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slave/mechanics/fem/green/bending_table.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Estimate for nested dissection of a compact mesh: operations grow with n^2, entries with n^(4/3).
PrecomputeCost ExpectedCost(int order) {
  const double n = order / 57000.0;
  const auto bytes = static_cast<std::size_t>(5e8 * std::pow(n, 4.0 / 3));
  return {2.5 * n * n + 0.3 * n, bytes};
}

void SolveGroup(const GreenGroups& layout, int group, int order, RestFactor* factor,
                std::span<double> values) {
  Eigen::MatrixXd columns(order, GreenGroups::kColumns);
  layout.SetLoads(group, columns);
  factor->Solve(columns);
  layout.TakeSurface(group, columns, values);
}

}  // namespace

GreenColumns::GreenColumns(RestStiffness stiffness, std::size_t memory_limit,
                           const std::filesystem::path& cache, Progress* progress)
    : stiffness_(std::move(stiffness)),
      layout_(stiffness_),
      memory_limit_(memory_limit),
      groups_(Index(layout_.groups())),
      column_of_place_(Index(layout_.places()), nullptr) {
  const TetMesh& elements = stiffness_.elements;
  if (!elements.modulus.empty()) {
    std::vector<double> sum(elements.nodes.size(), 0), count(elements.nodes.size(), 0);
    for (int e = 0; e < elements.element_count(); ++e) {
      for (const int node : elements.element(e)) {
        sum[Index(node)] += elements.ModulusOf(e);
        count[Index(node)] += 1;
      }
    }
    for (int p = 0; p < layout_.places(); ++p) {
      const auto node = Index(layout_.node_of_place()[Index(p)]);
      moduli_.push_back(count[node] > 0 ? sum[node] / count[node] : 1);
    }
  }
  if (!cache.empty()) cache_ = layout_.Cache(cache);
  bool all_kept = cache_.enabled();
  for (int g = 0; g < layout_.groups() && all_kept; ++g) all_kept = cache_.Has(g);
  if (!all_kept) Factorise(progress);
}

void GreenColumns::Factorise(Progress* progress) {
  if (factor_) return;
  if (progress != nullptr) progress->Expect(ExpectedCost(order()));
  ReportProgress(progress, "factorising stiffness", 0);
  Factor();
  ReportProgress(progress, "factorising stiffness", 1);
}

RestFactor& GreenColumns::Factor() {
  if (!factor_) factor_.emplace(stiffness_);
  return *factor_;
}

std::size_t GreenColumns::memory_bytes() const {
  const auto entries = stiffness_.lower.nonZeros() + stiffness_.regularised.nonZeros();
  return column_bytes_ + static_cast<std::size_t>(entries) * 12 +
         (factor_ ? factor_->memory_bytes() : 0);
}

const double* GreenColumns::Compute(int place) {
  const int group = place / GreenGroups::kGroup;
  const std::size_t count = layout_.values(group);
  const std::size_t bytes = count * sizeof(double);
  if (column_bytes_ + bytes > memory_limit_) return nullptr;
  auto values = std::make_unique<double[]>(count);
  const std::span view(values.get(), count);
  if (!cache_.Load(group, view)) {
    ComputeGroup(group, view);
    cache_.Save(group, view);
  }
  column_bytes_ += bytes;
  groups_[Index(group)] = std::move(values);
  for (int k = 0; k < layout_.count(group); ++k) {
    column_of_place_[Index(layout_.first(group) + k)] =
        view.data() + layout_.per_place() * Index(k);
  }
  return column_of_place_[Index(place)];
}

void GreenColumns::ComputeGroup(int group, std::span<double> values) {
  SolveGroup(layout_, group, order(), &Factor(), values);
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
    for (int c = 0; c < 3; ++c) {
      const int row = layout_.RowOf(places[i], c);
      if (row >= 0) x[row] += forces[i][c];
    }
  }
  Factor().Solve(x);
  stiffness_.Spread(x, displacement);
}

CacheFilling FillColumnCache(const RestStiffness& stiffness, double width,
                             const std::filesystem::path& cache, Progress* progress) {
  const GreenGroups layout(stiffness);
  const ColumnCache kept = layout.Cache(cache);
  BendingTable bending(stiffness, layout, width, cache);
  CacheFilling filling;
  std::vector<int> missing;  // groups of the bending table follow those of columns
  std::vector<double> values;
  const int all = layout.groups() + bending.groups();
  for (int group = 0; group < all; ++group) {
    const int of_bending = group - layout.groups();
    if (of_bending < 0) values.resize(layout.values(group));
    const bool is_kept = of_bending < 0 ? kept.Load(group, values) : bending.HasGroup(of_bending);
    if (!is_kept) missing.push_back(group);
    ++filling.groups;
  }
  if (missing.empty()) return filling;
  const int order = static_cast<int>(stiffness.lower.rows());
  if (progress != nullptr) progress->Expect(ExpectedCost(order));
  ReportProgress(progress, "factorising stiffness", 0);
  RestFactor factor(stiffness);
  for (const int group : missing) {
    ReportProgress(progress, "Green's functions",
                   static_cast<double>(filling.computed) / static_cast<double>(missing.size()));
    if (group < layout.groups()) {
      values.resize(layout.values(group));
      SolveGroup(layout, group, order, &factor, values);
      kept.Keep(group, values);
    } else {
      bending.KeepGroup(group - layout.groups(), &factor);
    }
    ++filling.computed;
  }
  ReportProgress(progress, "Green's functions", 1);
  return filling;
}

}  // namespace palpate

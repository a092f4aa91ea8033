// Surface Green's functions of a fixed elastic body, condensed from a finite element stiffness:
// column j is K^-1 e_j at the surface nodes. Computed when first requested.
//
// Source: James and Pai (2003), sec. 4 (Green's functions from any linear code).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/mechanics/fem/green/green_groups.h"
#include "slave/mechanics/fem/green/rest_stiffness.h"
#include "slave/program/progress.h"

namespace palpate {

// Columns are computed in fixed groups of neighbours, so that results do not depend on the order of
// requests, and the columns near a tool are ready. Not thread-safe.
class GreenColumns final : public Compliance {
 public:
  static constexpr int kGroup = GreenGroups::kGroup;  // places

  // `memory_limit` for columns [bytes]: beyond it Column() is nullptr. `cache` keeps groups on
  // disk. Factorises at once unless the cache has every group. Throws: see RestFactor; Interrupted.
  GreenColumns(RestStiffness stiffness, std::size_t memory_limit,
               const std::filesystem::path& cache, Progress* progress);

  [[nodiscard]] int places() const override { return layout_.places(); }
  const double* Column(int place) override {
    const double* column = column_of_place_[static_cast<std::size_t>(place)];
    return column != nullptr ? column : Compute(place);
  }
  // Makes the factor of the stiffness now; otherwise the first solution that needs it does.
  void Factorise(Progress* progress);
  RestFactor& Factor();
  // Returns whether the column is already computed.
  [[nodiscard]] bool IsReady(int place) const {
    return column_of_place_[static_cast<std::size_t>(place)] != nullptr;
  }
  [[nodiscard]] double modulus(int place) const override {
    return moduli_.empty() ? 1 : moduli_[Index(place)];
  }
  [[nodiscard]] double length_unit() const override { return stiffness_.length_unit; }
  [[nodiscard]] std::size_t memory_bytes() const override;

  // Computes the columns of some places in advance. False: the memory for them is used up. Throws
  // Interrupted; finished columns are kept, also on disk.
  bool Prefetch(std::span<const int> places, Progress* progress);

  // Displacement of every node of the elements by forces on places, by one sparse solution;
  // nondimensional.
  void Solve(std::span<const int> places, std::span<const Eigen::Vector3d> forces,
             std::vector<Eigen::Vector3d>* displacement);

  [[nodiscard]] const RestStiffness& stiffness() const { return stiffness_; }
  [[nodiscard]] const GreenGroups& layout() const { return layout_; }
  [[nodiscard]] const std::vector<int>& node_of_place() const { return layout_.node_of_place(); }
  [[nodiscard]] const std::vector<int>& place_of_node() const { return layout_.place_of_node(); }
  [[nodiscard]] int order() const { return static_cast<int>(stiffness_.lower.rows()); }
  [[nodiscard]] std::size_t bytes_per_place() const { return sizeof(double) * layout_.per_place(); }
  [[nodiscard]] int groups_computed() const { return groups_computed_; }
  [[nodiscard]] bool has_factor() const { return factor_.has_value(); }

 private:
  const double* Compute(int place);
  void ComputeGroup(int group, std::span<double> values);

  RestStiffness stiffness_;
  GreenGroups layout_;
  std::size_t memory_limit_;
  ColumnCache cache_;
  std::optional<RestFactor> factor_;
  std::vector<std::unique_ptr<double[]>> groups_;
  std::vector<const double*> column_of_place_;
  std::size_t column_bytes_ = 0;
  int groups_computed_ = 0;
  std::vector<double> moduli_;  // per place, means of the elements around; empty: all one
};

// Computes the groups of columns that GreenColumns stores in the folder `cache`, and those of the
// bending of a slender body under contacts of `width` [m] (BendingTable), except existing ones.
// Factorises only if one is missing. Throws as GreenColumns; std::runtime_error: the folder cannot
// be written.
CacheFilling FillColumnCache(const RestStiffness& stiffness, double width,
                             const std::filesystem::path& cache, Progress* progress);

}  // namespace palpate

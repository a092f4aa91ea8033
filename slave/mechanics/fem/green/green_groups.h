// The places of a body's surface, and the groups of places whose Green's functions are computed and
// stored together.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/mechanics/fem/green/rest_stiffness.h"

namespace palpate {

// Places are the surface nodes, with the mid-edge nodes of ten-node elements, in the order of a
// space-filling curve, so that neighbours have close numbers. A group contains the columns of its
// places one after the other, each as in Compliance::Column.
class GreenGroups {
 public:
  static constexpr int kGroup = 8;             // places
  static constexpr int kColumns = 3 * kGroup;  // of every group; those beyond its places are zero

  // Stores a reference to its argument.
  explicit GreenGroups(const RestStiffness& stiffness);

  [[nodiscard]] int places() const { return static_cast<int>(node_of_place_.size()); }
  [[nodiscard]] int groups() const { return (places() + kGroup - 1) / kGroup; }
  [[nodiscard]] static int first(int group) { return group * kGroup; }
  [[nodiscard]] int count(int group) const { return std::min(kGroup, places() - first(group)); }
  // Returns the count of numbers per place.
  [[nodiscard]] std::size_t per_place() const { return 9 * node_of_place_.size(); }
  [[nodiscard]] std::size_t values(int group) const {
    return per_place() * static_cast<std::size_t>(count(group));
  }
  // The row of the stiffness; -1: fixed.
  [[nodiscard]] int RowOf(int place, int component) const;

  // A unit force along each component of a group's places, one column each.
  void SetLoads(int group, Eigen::Ref<Eigen::MatrixXd> columns) const;
  // The group's values from the solutions for these loads.
  void TakeSurface(int group, const Eigen::Ref<const Eigen::MatrixXd>& columns,
                   std::span<double> values) const;

  [[nodiscard]] ColumnCache Cache(const std::filesystem::path& folder) const {
    return {folder, hash_};
  }

  [[nodiscard]] const std::vector<int>& node_of_place() const { return node_of_place_; }
  [[nodiscard]] const std::vector<int>& place_of_node() const { return place_of_node_; }

 private:
  const RestStiffness& stiffness_;
  std::uint64_t hash_;
  std::vector<int> node_of_place_, place_of_node_;
};

}  // namespace palpate

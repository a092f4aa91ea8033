// Green's functions of a held linear body between nodes near each other: the displacement of the
// nodes around a node by unit forces on it. Any neighbourhood of the body can then be condensed by
// gathering blocks, at no cost of solution.
//
// Nondimensional as TetStiffness: lengths by the larger side, moduli by E. Single precision: they
// are exact to 1e-7 of the largest, far less than what linearity costs.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/mechanics/fem/green/tet_stiffness.h"
#include "slave/mechanics/linear/mumps.h"

namespace palpate {

// Columns come in fixed groups of neighbours, so that what was asked first does not change a digit.
// Not thread-safe.
class NearGreen {
 public:
  static constexpr int kGroup = 8;  // nodes

  // `memory_limit` for columns [bytes]. `cache` keeps groups on disk; empty: none are kept.
  // Factorises. Throws: see AssembleTetStiffness, SpdFactor.
  NearGreen(const SolidMesh& mesh, const HeldNodes& held, double nu, std::size_t memory_limit,
            const std::filesystem::path& cache);

  // Makes the columns of these nodes and of their groups reach to all nodes within `reach`, rounded
  // up to one of few values, and to the anchors. False: the memory limit is reached. Throws
  // Interrupted, std::bad_alloc; what was finished stays, on disk too.
  bool Prepare(std::span<const int> nodes, double reach, Progress* progress = nullptr);
  // Asking for it costs no solution.
  [[nodiscard]] bool IsReady(int node, double reach) const {
    return columns_[static_cast<std::size_t>(node)].reach >= reach;
  }
  // Displacements of `to` by unit forces on `from`, three rows and columns per node. What is not
  // within reach is zero; false: there is such a pair, or a column is missing. `missed`: these
  // pairs.
  bool Gather(std::span<const int> to, std::span<const int> from, Eigen::MatrixXf* G,
              std::vector<std::array<int, 2>>* missed = nullptr);
  // The same for anchors, by their numbers.
  bool GatherAtAnchors(std::span<const int> anchors, std::span<const int> from, Eigen::MatrixXf* G);

  // K^-1 times each column of forces, three numbers per node; held components zero.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& forces);

  // Nodes spread evenly over the body, which every column reaches.
  [[nodiscard]] const std::vector<int>& anchors() const { return anchors_; }
  // In units of length.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& positions() const { return positions_; }
  [[nodiscard]] double length_unit() const { return stiffness_.length_unit; }
  [[nodiscard]] std::size_t memory_bytes() const;
  [[nodiscard]] int columns_solved() const { return columns_solved_; }

 private:
  struct Column {
    double reach = 0;
    std::vector<int> nodes;      // within reach, rising
    std::vector<float> blocks;   // nine per node: 3 c + r is the displacement along r by c
    std::vector<float> anchors;  // nine per anchor
  };
  [[nodiscard]] int Row(int node, int component) const {
    return stiffness_.row[static_cast<std::size_t>(node)][static_cast<std::size_t>(component)];
  }
  void ComputeGroup(int group, double reach);
  void FindNodes(int group, double reach);
  void Take(const Eigen::MatrixXd& x, int in_group, int node);
  [[nodiscard]] ColumnCache CacheFor(double reach) const;
  [[nodiscard]] std::size_t GroupBytes(int group) const;
  bool LoadGroup(int group, double reach);
  void SaveGroup(int group, double reach) const;

  TetStiffness stiffness_;
  SpdFactor factor_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<int> order_;     // nodes, neighbours after each other
  std::vector<int> group_of_;  // per node
  std::vector<int> anchors_;
  std::vector<Column> columns_;  // per node
  std::vector<int> number_;      // per node, room: -1 between calls
  std::size_t memory_limit_, column_bytes_ = 0;
  std::filesystem::path cache_;
  int columns_solved_ = 0;
};

// Adds nodes of `from` that are far from each other: always the one farthest from all before, until
// there are `count`; of no node, the first.
void SpreadNodes(const std::vector<Eigen::Vector3d>& positions, std::span<const int> from,
                 int count, std::vector<int>* chosen);

}  // namespace palpate

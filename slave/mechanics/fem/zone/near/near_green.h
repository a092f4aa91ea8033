// Green's functions of a held linear body between nodes near each other: the displacement of the
// nodes around a node by unit forces on it. Any neighbourhood of the body can then be condensed by
// gathering blocks, at no cost of solution.
//
// Nodes come in groups of neighbours. Between two groups that are near there is one tile of
// numbers, whichever of the two is the cause (Maxwell and Betti), of three bytes each where they
// are close and else of two, by the tile's largest. Groups farther apart know each other through
// anchors: nodes spread over the body, between which the displacement is interpolated.
//
// Nondimensional as RestStiffness: lengths by the larger side, moduli by E.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/green/column_cache.h"
#include "slave/mechanics/fem/green/rest_stiffness.h"
#include "slave/mechanics/linear/spd_factor.h"
#include "slave/program/progress.h"

namespace palpate {

// Not thread-safe.
class NearGreen {
 public:
  static constexpr int kGroup = 8;  // nodes

  // `memory_limit` for columns [bytes]. `cache` keeps groups on disk; empty: none are kept.
  // Factorises. Throws: see AssembleAtRest, SpdFactor.
  NearGreen(const SolidMesh& mesh, const HeldNodes& held, double nu, std::size_t memory_limit,
            const std::filesystem::path& cache);

  // Makes the columns of these nodes and of their groups, without interpolation for all nodes
  // within `reach`, rounded up to one of few values. False: the memory limit is reached. Throws
  // Interrupted, std::bad_alloc; what was finished stays, on disk too.
  bool Prepare(std::span<const int> nodes, double reach, Progress* progress = nullptr);
  // Keeps a share of the groups of these nodes on disk, and none in memory; what is there is not
  // computed again. Throws Interrupted; std::runtime_error: the folder cannot be written.
  CacheFilling FillCache(std::span<const int> nodes, double reach, const CacheShare& share,
                         Progress* progress);
  // Asking for it costs no solution.
  [[nodiscard]] bool IsReady(int node, double reach) const {
    return groups_[static_cast<std::size_t>(GroupOf(node))].reach >= reach;
  }
  // Displacements of `to` by unit forces on `from`, three rows and columns per node. Beyond reach
  // they are interpolated. False: a column is missing, and the pair is zero where the other column,
  // which does as well within reach, is missing too; `missed`: these pairs.
  bool Gather(std::span<const int> to, std::span<const int> from, Eigen::MatrixXf* G,
              std::vector<std::array<int, 2>>* missed = nullptr);
  // The same for anchors, by their numbers, of ready columns; these are exact.
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
  // Nine numbers for each pair of nodes, which are at 8 i + j for the i-th node that moves and the
  // j-th of the group: 3 c + r is along r by c. Bytes: all first ones, then all second ones, which
  // count 2^-8 each, and so on.
  struct Tile {
    int group = 0;   // whose nodes move; below zero: eight anchors
    int bytes = 2;   // per number
    float step = 0;  // what one is
    std::size_t first = 0;
  };
  // Displacements by forces on the nodes of one group.
  struct Group {
    double reach = 0;
    std::vector<Tile> tiles;  // rising; without those that the other group has
    std::vector<std::int8_t> numbers;
    [[nodiscard]] const Tile* Find(int group) const;
    [[nodiscard]] std::size_t bytes() const { return sizeof(Tile) * tiles.size() + numbers.size(); }
    void Add(Tile tile);
  };
  // For a displacement at a node by those of anchors near it.
  struct Interpolation {
    std::array<int, 12> anchors{};
    std::array<float, 12> weights{};
  };
  struct Bucket;

  [[nodiscard]] int Row(int node, int component) const {
    return stiffness_.row[static_cast<std::size_t>(node)][static_cast<std::size_t>(component)];
  }
  [[nodiscard]] int GroupOf(int node) const {
    return place_[static_cast<std::size_t>(node)] / kGroup;
  }
  [[nodiscard]] int AnchorTiles() const;
  // Below zero: the anchors.
  [[nodiscard]] std::span<const int> NodesOf(int group) const;
  void Interpolate(int node);
  [[nodiscard]] double Gap(int a, int b) const;
  [[nodiscard]] std::vector<int> GroupsToCompute(std::span<const int> nodes, double reach) const;
  // With the tiles of a group and without their numbers.
  [[nodiscard]] Group EmptyGroup(int group, double reach) const;
  void ComputeGroup(int group, double reach);
  void SolveGroup(int group, Group* made);
  void Fill(const Eigen::MatrixXd& x, Tile* tile, std::int8_t* numbers) const;
  void Keep(int group, const Group& made);
  [[nodiscard]] ColumnCache CacheFor(double reach) const;
  bool Load(int group, Group* made) const;
  // As the cache keeps it.
  [[nodiscard]] static std::vector<double> Packed(const Group& made);
  [[nodiscard]] std::vector<Bucket> Buckets(std::span<const int> nodes) const;
  bool GatherTile(const Bucket& to, const Bucket& from, Eigen::MatrixXf* G) const;
  bool GatherFar(std::span<const Bucket* const> to, const Bucket& from, Eigen::MatrixXf* G) const;
  [[nodiscard]] std::vector<float> AtAnchors(int node) const;
  [[nodiscard]] Eigen::Matrix3f FarBlock(int node, const std::vector<float>& at_anchors) const;

  RestStiffness stiffness_;
  SpdFactor factor_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<int> order_;                // nodes, group by group
  std::vector<int> place_;                // of each node in it
  std::vector<Eigen::Vector3d> centres_;  // of the groups
  std::vector<double> radii_;
  std::vector<int> anchors_;
  std::vector<Interpolation> interpolations_;  // per node
  std::vector<Group> groups_;
  std::size_t memory_limit_, column_bytes_ = 0;
  std::filesystem::path cache_;
  int columns_solved_ = 0;
};

// Adds nodes of `from` that are far from each other: always the one farthest from all before, until
// there are `count`; of no node, the first.
void SpreadNodes(const std::vector<Eigen::Vector3d>& positions, std::span<const int> from,
                 int count, std::vector<int>* chosen);

}  // namespace palpate

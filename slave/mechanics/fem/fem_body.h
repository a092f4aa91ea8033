// A body of linear tetrahedra, ready to be solved: nondimensional, its nodes in the order of
// elimination, its matrices assembled from where each element adds to them.
//
// Units: length the larger side of the bounding box, stress Young's modulus; mass density times
// length cubed, so that time runs in units of length / wave speed.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/tet_elements.h"
#include "slave/mechanics/linear/block_matrix.h"

namespace palpate::fem {

class FemBody {
 public:
  struct Params {
    double poisson_ratio = 0;
    TetElements::Law law = TetElements::Law::kCorotational;
  };

  // `held`: per node and component. Throws std::invalid_argument: no element, more than 4 million,
  // nodes that are not finite or do not exist, an element without positive volume.
  FemBody(const SolidMesh& mesh, const HeldNodes& held, const Params& params);

  // Nodes [0, moving()) have a component that is not fixed; the others come after them.
  [[nodiscard]] int moving() const { return moving_; }
  [[nodiscard]] int size() const { return static_cast<int>(points_.size()); }
  [[nodiscard]] TetElements::Law law() const { return elements_.law(); }
  [[nodiscard]] int element_count() const { return elements_.size(); }
  [[nodiscard]] double length_unit() const { return length_unit_; }  // [m]
  // The body's number of a node of the mesh, and back.
  [[nodiscard]] int Number(int mesh_node) const {
    return number_[static_cast<std::size_t>(mesh_node)];
  }
  // The mesh's number of one of the body's elements.
  [[nodiscard]] int MeshElement(int element) const {
    return mesh_element_[static_cast<std::size_t>(element)];
  }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& points() const { return points_; }
  // 1 free, 0 fixed, per node and component; nodes of no element count as fixed.
  [[nodiscard]] const NodeVector& free() const { return free_; }
  [[nodiscard]] const BlockPattern& pattern() const { return pattern_; }
  // Returns a node's share of the volume: a quarter of each of its elements; 0: it has no elements.
  [[nodiscard]] double Volume(int node) const { return volume_[static_cast<std::size_t>(node)]; }
  // Approximate stiffness of one node of the body at rest along an axis [E length].
  [[nodiscard]] double Stiffness(int node) const {
    return isotropic_[static_cast<std::size_t>(pattern_.diagonal[static_cast<std::size_t>(node)])];
  }
  // Per node: which of the body's connected parts it belongs to; -1: none, it has no element.
  [[nodiscard]] const std::vector<int>& part() const { return part_; }
  [[nodiscard]] int parts() const { return parts_; }

  // Forces, energy and rotations at a displacement; the two below are of the last one.
  ElementSummary Evaluate(const NodeVector& u) noexcept { return elements_.Evaluate(u); }
  // Computes the same and the tangent: exact for the neo-Hookean law, plus `shift` times a
  // stiffness against every gradient; for other laws that of AssembleTangent.
  ElementSummary EvaluateWithTangent(const NodeVector& u, double shift,
                                     BlockMatrix& tangent) noexcept;
  void ForgetRotations() noexcept { elements_.ForgetRotations(); }
  void InternalForce(NodeVector& f) noexcept;
  // mass M + stiffness K, K with warped element matrices R K_0 R^T; for the linear law K is K_0.
  // Not for the neo-Hookean law.
  void AssembleTangent(double mass, double stiffness, BlockMatrix& matrix) noexcept;
  // The mean rotation of a few of each moving node's elements, as a unit quaternion s, x, y, z.
  void NodeRotations(NodeVector& rotations) const noexcept;
  void MultiplyMass(const NodeVector& x, NodeVector& y) const noexcept {
    MultiplyScalars(pattern_, mass_, x, y);
  }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  void Number(const SolidMesh& mesh, const HeldNodes& held);
  void SortElements();
  void FindContributions();
  void FindTouching();
  void FindPairs();
  void MirrorUpper(BlockMatrix& matrix) noexcept;

  double length_unit_ = 1;
  int moving_ = 0;
  std::vector<int> number_, mesh_element_;
  std::vector<Eigen::Vector3d> points_;
  NodeVector free_;
  std::vector<double> volume_;  // per node
  std::vector<int> part_;
  int parts_ = 0;
  BlockPattern pattern_;
  std::vector<std::array<int, 4>> tets_;
  TetElements elements_;

  std::vector<int> upper_;          // blocks at or right of the diagonal
  std::vector<int> corners_begin_;  // per upper block, in corners_
  std::vector<int> corners_;        // pairs a, b of one element, in elements_.corner_gradients()
  NodeGraph touching_;              // per node: corners of its elements
  std::vector<TetElements::GroupBlocks> pairs_;  // of the neo-Hookean law's tangents
  std::vector<double> mass_;                     // per block
  std::vector<double> isotropic_;                // per block: sum mu V g_a . g_b
};

}  // namespace palpate::fem

// The linear tetrahedra of a body: forces, energy and rotated shape gradients at a displacement.
//
//   G = sum_a u_a g_a^T,  F = I + G = R S,  E = S - I,
//   P = R (2 mu E + lambda tr(E) I),  f_a = V P g_a,  W = V (mu |E|^2 + lambda / 2 tr(E)^2)
//
// with the signed polar rotation R (det R = +1), or R = I and E = sym(G) in the linear law. The
// neo-Hookean law is that of neo_hookean_lanes.h. Source: Mueller and Gross (2004), paper B [21];
// the law is linear in E, as there. Nondimensional: lengths are divided by the caller's unit,
// stresses by E.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/lanes.h"
#include "slave/mechanics/tet_mesh.h"

namespace palpate::fem {

// Further results of an evaluation.
struct ElementSummary {
  double energy = 0;
  int inverted = 0;         // elements with det F <= 0
  int first_inverted = -1;  // index of the first one
};

// Destination of tangents: nine numbers per block, for the blocks at or above the diagonal.
struct TangentTarget {
  double* values = nullptr;
  double shift = 0;  // added to the law's multiple of the identity [E]
};

// Eight elements in vector lanes; the last group is filled up with elements of zero volume.
struct alignas(64) TetGroup {
  std::array<std::array<int, kLanes>, 4> node{};
  std::array<std::array<Double8, 3>, 3> gradient{};  // shape gradients of corners 1 to 3
  Double8 volume{};                                  // V, times the element's modulus
  Double8 root_volume_mu{};                          // sqrt(V mu)
  std::array<Double8, 4> quaternion{};               // s, x, y, z
  Double8 energy{}, determinant{};                   // V-weighted; det F
};

class TetElements {
 public:
  enum class Law { kLinear, kCorotational, kNeoHookean };
  // Per pair of corners (PairOf) and element of a group: the block between their nodes.
  using GroupBlocks = std::array<std::array<int, kLanes>, 10>;

  // `mesh`: its tetrahedra may be in any order, for example one with good memory locality; `lame`
  // is multiplied by each one's modulus. Volumes must be positive.
  TetElements(const SolidMesh& mesh, const Lame& lame, Law law);

  // Rotations start from those of the last evaluation. Allocation-free.
  ElementSummary Evaluate(const NodeVector& u) noexcept;
  // Evaluates the neo-Hookean law and adds its tangent in one pass.
  ElementSummary EvaluateWithTangent(const NodeVector& u, std::span<const GroupBlocks> blocks,
                                     const TangentTarget& tangent) noexcept;
  // Resets rotations to the identity.
  void ForgetRotations() noexcept;

  [[nodiscard]] int size() const { return count_; }
  [[nodiscard]] int groups() const { return static_cast<int>(groups_.size()); }
  [[nodiscard]] Law law() const { return law_; }
  [[nodiscard]] const Lame& lame() const { return lame_; }
  // Per element and corner, at [4 element + corner], of the last evaluation.
  [[nodiscard]] const NodeVector& corner_forces() const { return forces_; }
  // q_a = sqrt(V mu) R g_a; of the neo-Hookean law at rest.
  [[nodiscard]] const NodeVector& corner_gradients() const { return gradients_; }
  // The quaternion s, x, y, z of an element's rotation.
  [[nodiscard]] NodeValue Rotation(int element) const noexcept {
    const TetGroup& group = groups_[static_cast<std::size_t>(element / kLanes)];
    const int l = element % kLanes;
    const auto& q = group.quaternion;
    return {{q[0][l], q[1][l], q[2][l], q[3][l]}};
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return groups_.size() * sizeof(TetGroup) + 2 * forces_.size() * sizeof(NodeValue);
  }

 private:
  [[nodiscard]] ElementSummary Summary() const noexcept;

  int count_ = 0;
  Lame lame_;
  Law law_;
  std::vector<TetGroup> groups_;
  NodeVector forces_, gradients_;
};

}  // namespace palpate::fem

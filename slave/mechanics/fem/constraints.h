// The admissible motions of a body's nodes under supports and contacts that prescribe nodes or
// points. In statics free rigid motions are removed by a zero mean.
//
// With C u = d for the prescribed displacements and Z the free rigid motions (Z^T M Z = I) the
// possible changes are the range of P = (I - Z Z^T M) P_C, P_C the orthogonal projector on the
// kernel of C. Contacts share no node, so the rows of C are orthogonal and P_C costs as many
// operations as C has entries.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/held_motions.h"
#include "slave/mechanics/footprint/contact_footprint.h"
#include "slave/mechanics/linear/block_matrix.h"
#include "slave/mechanics/linear/two_grid.h"

namespace palpate::fem {

// Changes that factors and preconditioners make to a tangent: rows and columns of components that
// are fixed get ones on the diagonal, and a weighted sum of a component that is fixed gets a
// penalty.
struct HeldComponents {
  struct Sum {
    int node[3] = {-1, -1, -1};
    NodeValue weight[3];  // per component
  };
  NodeVector free;            // per node and component: 1 free, 0 fixed
  std::vector<Sum> sums;      // sums over nodes that share an element
  std::vector<Guide> guides;  // nodes that may move in a plane only
  double shift = 0;           // added to the diagonal, relative to it: where rigid motions are free
};

// A node that a tool touches: its displacement is `target`, or only its component along `normal`
// is.
struct TouchedNode {
  int node = -1;
  bool sticks = false;
  Eigen::Vector3d normal{0, 0, 1};  // unit
  Eigen::Vector3d target{0, 0, 0};
  double slack = 0;  // accepted distance from the target
};

class Constraints {
 public:
  // Stores a reference to the body.
  explicit Constraints(const FemBody& body);

  // Removes all contacts; the supports stay.
  void Clear();
  // The functions below each add one contact, numbered from 0. False: a node is already fixed by
  // another contact. HoldNodes: all nodes have the same displacement; weights are ignored.
  [[nodiscard]] bool HoldNodes(std::span<const PlaceWeight> nodes);
  // The weighted mean of at most three nodes.
  [[nodiscard]] bool HoldPoint(std::span<const PlaceWeight> nodes);
  // Replaces the list of nodes that tools touch. Supports and other contacts must not fix them.
  // Does not allocate beyond the reserved memory.
  void HoldTouched(std::span<const TouchedNode> nodes);
  void ReserveTouched(std::size_t most);
  // Returns whether another contact fixes the node.
  [[nodiscard]] bool IsTaken(int node) const {
    return taken_by_[static_cast<std::size_t>(node)] != 0;
  }
  // Finds the rigid motions that are free, with or without touching tools. Returns false if there
  // are more than 24.
  [[nodiscard]] bool FindFreeMotions();

  // Prescribes the displacement of contact k. False: it is not zero along a fixed component.
  [[nodiscard]] bool Move(int k, const Eigen::Vector3d& displacement);

  // lift = the smallest change of u that brings the contacts to `share` of their prescribed
  // displacement, without free motions. Returns its largest component beyond what touched nodes may
  // have, and beyond rounding.
  double Lift(const NodeVector& u, double share, NodeVector& lift) const noexcept;
  // held = the part of u that contacts prescribe, which P removes together with that of supports.
  void HeldPart(const NodeVector& u, NodeVector& held) const noexcept;
  void ProjectMotion(NodeVector& change) const noexcept;  // P
  void ProjectForce(NodeVector& force) const noexcept;    // P^T
  // Calls `action` with each moving node on which supports or contacts act, some of them twice.
  // False: they act on all, since free motions are removed.
  template <class Action>
  bool ForBearing(const Action& action) const {
    if (motion_count_ > 0) return false;
    for (int i = 0; i < body_.moving(); ++i) {
      const double* free = At(held_.free, i).v;
      if (free[0] * free[1] * free[2] == 0) action(i);
    }
    for (const auto& sum : held_.sums) {
      for (const int i : sum.node) {
        if (i < body_.moving()) action(i);
      }
    }
    for (const Guide& guide : held_.guides) action(guide.row);
    return true;
  }
  // The force of contact k, where `force` contains the nodal forces of contacts and supports.
  [[nodiscard]] Eigen::Vector3d Sum(int k, const NodeVector& force) const noexcept;
  [[nodiscard]] bool has_free_motions() const { return motion_count_ > 0; }
  // P is one of each node: held() says all of it.
  [[nodiscard]] bool AreOfNodes() const { return held_.sums.empty() && motion_count_ == 0; }
  // The largest part of a free motion in `force`, of the forces' sizes together.
  [[nodiscard]] double Imbalance(const NodeVector& force) const noexcept;
  [[nodiscard]] const HeldComponents& held() const { return held_; }

 private:
  struct Contact {
    std::size_t begin = 0, end = 0;  // in nodes_
    int sum = -1;                    // in held_.sums; -1: all nodes are fixed
    Eigen::Vector3d target{0, 0, 0};
    NodeValue blocked;  // per component: 1 where supports fix it
  };

  bool Take(std::span<const PlaceWeight> nodes);
  void ProjectSums(NodeVector& x) const noexcept;  // and the planes of guided nodes
  void RemoveMotions(NodeVector& x) const noexcept;
  void HoldMotions(int part, HeldMotions* motions) const;
  bool AddMotion(int part, const HeldMotions& motions, const HeldMotions::Motion& motion);

  const FemBody& body_;
  HeldComponents held_;
  std::vector<Contact> contacts_;
  std::vector<int> nodes_;
  std::vector<TouchedNode> touched_;
  std::vector<int> taken_by_;                           // per node: contact + 1
  std::vector<NodeVector> motions_, weighted_motions_;  // Z and M Z; never shrink
  int motion_count_ = 0;
};

}  // namespace palpate::fem

// Supports of a body, and the treatment of rigid motions that they do not prevent.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/fem/held_motions.h"
#include "slave/mechanics/fem/solid/equilibrium.h"
#include "slave/mechanics/fem/solid/sparse_system.h"
#include "slave/mechanics/tet_mesh.h"
#include "slave/mesh/index.h"

namespace palpate {

class Supports {
 public:
  // Stores references to its arguments. `volumes`: of every node's shape function, the weights of
  // means.
  Supports(const TetMesh& mesh, const BlockLayout& layout, const HeldNodes& held,
           Eigen::VectorXd volumes);

  // Marks the unknowns that the scene fixes, and nodes without element.
  void Hold(Balance* balance) const;
  // Returns whether this displacement of `node` would move a component that the scene fixes.
  [[nodiscard]] bool Forbids(int node, const Eigen::Vector3d& displacement) const;
  // Finds the rigid motions that neither fixed unknowns nor rows prevent, and fixes as many further
  // unknowns, so that the body is stationary. O(N).
  void Pin(Balance* balance);
  [[nodiscard]] bool is_free() const { return free_motions_.cols() > 0; }
  // Returns the work of `force` on the free motions, relative to its largest possible value [-].
  [[nodiscard]] double Imbalance(const Eigen::VectorXd& force) const;
  // Force that the pins carry; `unbalanced` is that of Equilibrium.
  [[nodiscard]] double PinForce(const Eigen::VectorXd& unbalanced) const;
  // Removes the free motions from x, so that mean displacement and rotation are zero.
  void RemoveFreeMotion(Eigen::VectorXd* x) const;

 private:
  using Motion = fem::HeldMotions::Motion;
  // Displacement component `component` of a node under each unit motion.
  [[nodiscard]] Motion Row(int node, int component) const {
    return motions_.Row(mesh_.nodes[Index(node)], component);
  }
  [[nodiscard]] fem::HeldMotions Held(const Balance& balance) const;
  [[nodiscard]] bool Used(int node) const { return used_[static_cast<std::size_t>(node)]; }

  const TetMesh& mesh_;
  const BlockLayout& layout_;
  HeldNodes held_;  // including mid-edge nodes
  Eigen::VectorXd volumes_;
  std::vector<bool> used_;
  fem::HeldMotions motions_;                 // rigid motions of a body without supports
  std::vector<int> node_of_, component_of_;  // per unknown; -1: a pressure
  fem::HeldMotions::Motions free_motions_;
  std::vector<int> pins_;
};

}  // namespace palpate

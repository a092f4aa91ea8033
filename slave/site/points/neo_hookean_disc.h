// Elastic forces and stiffness of a thick plate of neo-Hookean rubber, without any assumption on
// its kinematics.
//
// Nondimensional: stresses by E, lengths as the mesh. Total Lagrangian, Gauss's rule with four
// points in each direction. Displacements alone are unknowns: cubic ones do not lock.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/sparse_ldlt.h"
#include "slave/site/points/disc_mesh.h"
#include "slave/site/points/neo_hookean.h"

namespace palpate::site {

class NeoHookeanDisc {
 public:
  using Matrix = SparseLdlt::Matrix;

  // Keeps a reference to the mesh. -1 < nu < 0.5; `tension` at rest in the plate's plane, >= 0.
  NeoHookeanDisc(const DiscMesh& mesh, double nu, double tension = 0);

  // Unknowns: column by column of the mesh, upward, x, y, z.
  [[nodiscard]] int size() const { return 3 * mesh_.levels() * mesh_.free_columns(); }
  [[nodiscard]] int unknown(int column, int level, int component) const {
    return 3 * (mesh_.levels() * column + level) + component;
  }
  // Elastic forces at displacements u; where the mirror planes hold, zero. False: an element is
  // turned inside out.
  bool Forces(const Eigen::VectorXd& u, Eigen::VectorXd* forces) const;
  // Also their derivatives, upper triangle, with the pattern of EmptyMatrix().
  bool Linearise(const Eigen::VectorXd& u, Eigen::VectorXd* forces, Matrix* stiffness) const;
  [[nodiscard]] Matrix EmptyMatrix() const;
  // Load of one along -z, spread evenly over the outer face below the tool.
  [[nodiscard]] Eigen::VectorXd ToolLoad() const;

 private:
  static constexpr int kColumns = DiscMesh::kElementColumns;
  static constexpr int kLevels = DiscMesh::kThrough + 1;
  static constexpr int kNodes = kColumns * kLevels;
  static constexpr int kPoints = kColumns * kLevels;
  struct Element {
    std::array<int, kColumns> columns{};
    std::array<int, kColumns * kColumns> positions{};  // of the block (i, j) in the columns of j
    int layer = 0;
    Eigen::MatrixXd gradients;  // of the shape functions: nodes x 3 per point [1 / length]
    Eigen::VectorXd weights;    // volumes of the points
  };
  struct Work;

  void AddElement(int ring, int ray, int layer);
  void FindPattern();
  bool Accumulate(const Eigen::VectorXd& u, Eigen::VectorXd* forces, Matrix* stiffness) const;
  bool Integrate(const Element& element, const Eigen::VectorXd& u, bool with_stiffness,
                 Work* work) const;
  void HoldMirrorPlanes(Matrix* stiffness) const;
  void AddForces(const Element& element, const Work& work, Eigen::VectorXd* forces) const;
  void AddStiffness(const Element& element, const Work& work, Matrix* stiffness) const;

  const DiscMesh& mesh_;
  NeoHookean rubber_;
  std::vector<Element> elements_;
  Eigen::VectorXd free_;                 // 0 for what the mirror planes hold, else 1
  std::vector<std::vector<int>> upper_;  // per free column: those before it that it couples with
};

}  // namespace palpate::site

// Green's functions of a planar elastic body: the effect of every boundary element on every other
// one under the reference boundary conditions (paper A, eqs. 3-6; James and Pai 2003).
//
// H P = G V, H = I / 2 + principal values of the traction kernel, collocated at the elements'
// nodes: the midpoint of constant elements, two or three points of linear and quadratic ones. The
// columns of H and G are sorted by the unknowns of the reference problem, A_0 Y + Abar_0 Ybar = 0,
// and E = -A_0^-1 Abar_0 maps prescribed quantities to unknown ones: tractions to displacements
// where the body is free, displacements to reactions where it is fixed.
//
// Nondimensional inside: lengths are divided by the mesh's length unit, tractions by E.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem/boundary_system.h"
#include "slave/mechanics/bem/element_error.h"
#include "slave/mechanics/capacitance/compliance.h"
#include "slave/mechanics/linear/dense_lu.h"
#include "slave/program/progress.h"

namespace palpate {

// The places of this Compliance are the nodes, and their amplitudes are tractions.
class GreensFunctions final : public Compliance {
 public:
  // Poisson ratio in plane strain up to which a body with holes needs no equation for the holes'
  // pressures: the error of the plain equations grows as 1 / (1 - 2 nu), 5 % for constant elements
  // at 0.49 with 60 elements on the hole. Beyond it, and always for linear and quadratic elements,
  // BoundarySystem::AppendHolePressures avoids this growth.
  static constexpr double kMaxNuWithoutHolePressures = 0.49;
  // Largest Poisson ratio in plane strain when displacements are prescribed on the whole boundary:
  // the pressure level is then known only through 1 / (1 - 2 nu).
  static constexpr double kMaxNuAllHeld = 0.499;

  // Assembles and solves: O(N^3), N nodes. Reports to `progress`, if there is one. Throws
  // std::invalid_argument: fewer than three elements, elements without length, nu out of range or
  // too near 0.5 (see above), a system that is singular to working precision; Interrupted.
  explicit GreensFunctions(ReferenceProblem problem, Progress* progress = nullptr);
  // Estimates time and memory on a present machine with one thread and the portable build.
  static PrecomputeCost Estimate(int elements, ElementOrder order);

  // Returns the 2x2 block of E, column-major: the effect of node `j`'s prescribed components at
  // node `i`. A block is at most one cache line; the blocks of a column `j` are contiguous.
  [[nodiscard]] const double* block(int i, int j) const {
    return blocks_.get() +
           4 * (static_cast<std::size_t>(j) * stride_ + static_cast<std::size_t>(i));
  }

  // A body that is not fixed against all rigid motions gets two more blocks, [size(),
  // block_count()): prescribed are the mean rigid motions (zero in the reference), unknown the
  // balancing tractions, amplitude by mode, that a load which is not balanced would need.
  [[nodiscard]] int size() const { return static_cast<int>(nodes_.size()); }
  [[nodiscard]] int block_count() const { return static_cast<int>(stride_); }
  // Returns the displacement at `p_O` [m] for a unit amplitude of each free rigid motion, one
  // column each, zero beyond free_motions().
  [[nodiscard]] Eigen::Matrix<double, 2, 3> RigidModes(const Eigen::Vector2d& p_O) const noexcept;
  // 0: the body is fixed. An element that is fixed counts with both its ends, so that a single one
  // holds against rotation too.
  [[nodiscard]] int free_motions() const { return free_motions_; }

  [[nodiscard]] const ReferenceProblem& problem() const { return problem_; }  // mesh [m]
  [[nodiscard]] const PlaneElasticity& elasticity() const { return elasticity_; }
  [[nodiscard]] const ElementNodes& element_nodes() const {
    return ElementNodes::Of(problem_.order);
  }
  [[nodiscard]] const BoundaryNode& node(int i) const {
    return nodes_[static_cast<std::size_t>(i)];
  }
  // Length of the boundary that belongs to a node: the whole element's if it has one node.
  [[nodiscard]] const std::vector<double>& lengths() const { return lengths_; }  // [length units]
  [[nodiscard]] bool held(int i, int component) const {
    return problem_
        .held[static_cast<std::size_t>(node(i).element)][static_cast<std::size_t>(component)];
  }
  // See BoundarySystem::Inside.
  void Inside(const std::vector<Eigen::Vector2d>& places, Eigen::MatrixXd* H,
              Eigen::MatrixXd* G) const {
    BoundarySystem(problem_, nodes_, elasticity_).Inside(places, H, G);
  }
  [[nodiscard]] double condition() const { return condition_; }  // of A_0, 1-norm estimate
  [[nodiscard]] const ElementError& error() const { return error_; }
  [[nodiscard]] std::size_t memory_bytes() const override {
    return 4 * stride_ * stride_ * sizeof(double);
  }

  [[nodiscard]] int places() const override { return size(); }
  [[nodiscard]] int motions() const override { return block_count() - size(); }
  const double* Column(int place) override { return block(0, place); }
  [[nodiscard]] double measure(int place) const override { return lengths_[Index(place)]; }
  [[nodiscard]] std::array<bool, 3> Held(int place) override {
    return {held(place, 0), held(place, 1), true};
  }
  [[nodiscard]] Eigen::Matrix3d FreeBlock(const double* column, int by, int at) override;
  [[nodiscard]] double length_unit() const override { return problem_.mesh.length_unit; }

 private:
  void FindFreeMotions();
  void AppendFreeMotions(Eigen::MatrixXd* A, Eigen::MatrixXd* Abar) const;
  void Solve(DenseLu lu, Eigen::MatrixXd* E, Progress* progress);
  void StoreBlocks(const Eigen::MatrixXd& E);

  ReferenceProblem problem_;
  PlaneElasticity elasticity_;
  std::vector<BoundaryNode> nodes_;
  std::vector<double> lengths_;     // of the nodes
  Eigen::Vector2d mean_p_O_{0, 0};  // of the boundary [m]
  Eigen::Matrix3d motions_ =
      Eigen::Matrix3d::Identity();  // x, y, turn about the mean; free ones first
  int free_motions_ = 0;
  std::size_t stride_ = 0;
  struct Free {
    void operator()(double* memory) const noexcept;
  };
  std::unique_ptr<double, Free> blocks_;
  double condition_ = 0;
  ElementError error_;
};

// Displacements and tractions on the whole boundary, as a sum over the prescribed values of nodes.
class BoundarySum {
 public:
  explicit BoundarySum(const GreensFunctions& greens);
  // Adds a traction at node `j` on the free boundary, or the amplitude of one of the blocks beyond
  // the nodes. O(N).
  void Add(int j, const Eigen::Vector2d& value);
  void Finish(std::vector<Eigen::Vector2d>* displacement, std::vector<Eigen::Vector2d>* traction);

 private:
  const GreensFunctions& greens_;
  std::vector<Eigen::Vector2d> answer_, given_;
};

}  // namespace palpate

// Estimates the error of a body's compliance that is caused by the order of its elements. It is
// large for slender parts that bend.
//
// Between its nodes, the zeros of Legendre's P_n, the displacement of an element departs from the
// discrete one by c P_n(s) to first order; c follows from the neighbours' values. This departure is
// inserted into the collocated equations, A_0 Y + T(c P_n) = -Abar_0 Ybar, and changes the answer
// by
//
//   delta = -A_0^-1 T(c P_n)
//
// a step of iterated defect correction (Stetter, Numer. Math. 29, 1978). Forces f on the boundary
// do the work f . u / 2 in the discrete answer, and f . delta / 2 is missing: relative to each
// other they are the error of the compliance. Two steps are made. If the second term is not small,
// the series does not converge, and the sum of both terms shows this. There are no tuned constants.
//
// The estimate does not include the error of the tractions at supports. Compact bodies such as
// squares and discs do not bend, so nothing is estimated for them.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem/boundary_system.h"
#include "slave/mechanics/linear/dense_lu.h"
#include "slave/mesh/index.h"

namespace palpate {

class ElementError {
 public:
  ElementError() = default;
  // `lu`: of A_0; `E`: -A_0^-1 Abar_0; rows beyond the nodes' are extra equations. O(probes N^2).
  ElementError(const ReferenceProblem& problem, const std::vector<BoundaryNode>& nodes,
               const PlaneElasticity& elasticity, const DenseLu& lu, const Eigen::MatrixXd& E);

  // Elements that represent all elements of their part of the boundary; 0 on a compact body.
  [[nodiscard]] std::size_t probes() const { return elements_.size(); }
  [[nodiscard]] int ProbeOf(int element) const { return probe_of_[Index(element)]; }
  // Part of their work that is missing under forces on the probes [-]; infinite: they do none.
  [[nodiscard]] double MissingPart(std::span<const Eigen::Vector2d> forces) const noexcept;

 private:
  // Number of probes on the whole boundary [-]. [derived: each needs a column, 1 / N of the
  // precomputation; and in a slender body a part of 3 % of the boundary moves almost rigidly]
  static constexpr int kProbes = 32;
  static constexpr int kSteps = 2;

  void ChooseProbes(const ReferenceProblem& problem);
  void AddSide(const ReferenceProblem& problem, std::vector<int>* side);

  std::vector<int> elements_;  // per probe
  std::vector<int> probe_of_;  // per element
  // Mean displacements under unit forces along x and y: of the discrete answer, and of each step.
  std::array<Eigen::MatrixXd, 1 + kSteps> terms_;
};

}  // namespace palpate

// A clamped von Karman plate pressed at its centre: rotational symmetry leaves two functions of the
// radius, solved to nine digits.
//
// Nondimensional: the radius is divided by a, the deflection by t, the force by E t^4 / a^2, the
// tension (N per length) by E t^3 / a^2; D = 1 / (12 (1 - nu^2)). With the slope b = dw/dr and psi
// = r N_r,
//
//   D (r b'' + b' - b / r) = (psi + N0 r) b + F f(r) / (2 pi),   b(0) = b(1) = 0
//   r psi'' + psi' - psi / r = -b^2 / 2,   psi(0) = 0,   psi'(1) = nu psi(1)   (the edge stays)
//
// where f is the share of the load inside r: of a uniform load, or of a rigid flat face, which at
// the centre touches with its whole rim while the plate is concave inside. Source: von Karman 1910
// in the form of Foeppl and Hencky; Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells,
// art. 96-100. Weak form, polynomials of degree 8 on elements graded to the centre, the load's edge
// and the rim; psi is eliminated (the energy is then convex in b where the plate is in tension),
// Newton.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/lobatto.h"
#include "slave/mechanics/plate/pressed_places.h"

namespace palpate::plate {

// Last relative step of a solution; convergence is quadratic.
inline constexpr double kConverged = 1e-7;

// Returns the largest absolute entry; NaN if there is one. Unlike a sum of squares it does not
// underflow for entries below 1e-154.
template <typename Vector>
double LargestEntry(const Eigen::MatrixBase<Vector>& v) {
  return v.size() == 0 ? 0 : v.cwiseAbs().template maxCoeff<Eigen::PropagateNaN>();
}

// Solves for a goal by `newton` from the last solution, else in steps from rest that double the
// fraction of the goal. `newton(share)` returns whether it converged; `largest`: size of the whole
// goal, relative to one that can be reached from rest in one step. False: no solution, and the
// state is at rest.
template <typename Newton, typename Rest>
bool SolveBySteps(double largest, const Newton& newton, const Rest& rest) {
  if (newton(1)) return true;
  rest();
  int halvings = 0;
  while (std::ldexp(largest, -halvings) > 1 && halvings < 64) ++halvings;
  for (; halvings >= 0; --halvings) {
    if (newton(std::ldexp(1.0, -halvings))) continue;
    rest();
    return false;
  }
  return true;
}

// A = L D L^T for symmetric quasi-definite A (Vanderbei 1995: then no pivoting is needed).
class BandedSymmetric {
 public:
  // Entries (i, j) with |i - j| <= band.
  BandedSymmetric(int size, int band);

  void SetZero() { std::ranges::fill(rows_, 0.0); }
  // An entry of the lower half: i - band <= j <= i.
  [[nodiscard]] double& at(int i, int j) { return rows_[Place(i, j)]; }
  // Row and column `i` become those of the identity.
  void Hold(int i);
  // Factorises in place. False: a pivot vanishes or is not finite. O(size band^2), no allocation.
  bool Factorise() noexcept;
  // Overwrites the right-hand side. O(size band).
  void Solve(Eigen::Ref<Eigen::VectorXd> x) const noexcept;

 private:
  [[nodiscard]] std::size_t Place(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(band_ + 1) +
           static_cast<std::size_t>(j - i + band_);
  }

  int size_, band_;
  std::vector<double> rows_;  // row by row, the diagonal last
};

class RoundPress {
 public:
  // -1 < nu <= 0.5; load over a disc of radius 0 (a point) to 1; prestress N0 >= 0.
  RoundPress(double nu, double load_radius, double prestress = 0, Face face = Face::kEven);

  // Solves by Newton's method from the last solution, else in steps from rest. False: no solution
  // to 1e-9, and the plate is at rest. No allocation.
  bool SolveDeflection(double w) noexcept { return Solve({false, w}); }
  bool SolveForce(double force) noexcept { return Solve({true, force}); }
  void Reset() noexcept;

  [[nodiscard]] double force() const { return force_; }
  // Deflection at the centre of an even load, or of a rigid face.
  [[nodiscard]] double deflection() const { return depth_ * slope_; }
  [[nodiscard]] double stiffness() const { return stiffness_; }  // d force / d deflection

 private:
  struct Element {
    double inner = 0, outer = 0;
    int first = 0;  // its first node
  };
  struct Goal {
    bool is_force = false;
    double value = 0;
  };

  void Divide(double load_radius);
  void AssembleLinear(double nu, double load_radius, double prestress, Face face);
  bool Solve(const Goal& goal) noexcept;
  bool Newton(const Goal& goal) noexcept;
  bool Tangent() noexcept;
  void AddTension(const Element& element) noexcept;
  void UpdateTension() noexcept;

  std::vector<Element> elements_;
  Eigen::VectorXd radius_;                   // of the nodes
  Quadrature rule_;                          // on [0, 1]
  Interpolation polynomials_;                // of an element on [0, 1]
  BandedSymmetric bending_{0, 0};            // D (r b' b' + b b / r) + N0 r b b
  BandedSymmetric stretching_{0, 0};         // r psi' psi' + psi psi / r, less nu at the rim
  BandedSymmetric stretching_factor_{0, 0};  // the same, factorised
  BandedSymmetric tangent_{0, 0};            // slope and psi by turns
  Eigen::VectorXd slope_, psi_;              // b, psi at the nodes
  Eigen::VectorXd load_;      // work of a load of one on a unit slope at each node, by 2 pi
  Eigen::RowVectorXd depth_;  // deflection = depth_ * slope_
  Eigen::VectorXd residual_, step_, by_load_;
  double force_ = 0;
  double stiffness_ = 0;
};

}  // namespace palpate::plate

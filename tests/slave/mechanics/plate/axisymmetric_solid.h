// An independent reference: a clamped round plate under a rigid flat tool at its centre, as an
// axisymmetric solid.
//
// Compressible neo-Hookean rubber, W = mu / 2 (tr F^T F - 3) - mu ln J + lambda / 2 (ln J)^2, in
// cylindrical coordinates: F has the components rr, rz, zr, zz and, around the axis, 1 + u_r / r.
// Nine-node quadrilaterals, graded to the tool's edge, the rim and the outer face. The outer face
// below the tool moves by the depth along -z and slides along the tool; the rim is fixed through
// the thickness. Shares no code, mesh or law with slave/reference and slave/mechanics.
//
// Against twice as many elements each way: within 0.5 % of the force, for tools of 0.02 a or more.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Sparse>

namespace palpate {

// Lengths by the plate's radius, stresses by E.
class AxisymmetricPress {
 public:
  struct Params {
    double thickness = 0, tool_radius = 0;
    double poisson_ratio = 0.45;
    int below = 12, beside = 30, layers = 3;  // elements
  };
  explicit AxisymmetricPress(const Params& params);

  // Force at a depth, from the last one in equal steps. NaN: no equilibrium.
  double Force(double depth, int steps);

 private:
  using Gradient = Eigen::Matrix<double, 5, 1>;  // rr, rz, zr, zz, around
  struct Element;

  void Grade();
  [[nodiscard]] int unknown(int line, int level, int component) const {
    return 2 * (line * static_cast<int>(z_.size()) + level) + component;
  }
  bool Step(double depth);
  bool Assemble();
  bool Integrate(int line, int level, Element* element) const;
  bool Stress(const Gradient& F, Gradient* P, Eigen::Matrix<double, 5, 5>* tangent) const;

  Params params_;
  double mu_, lambda_;
  std::vector<double> r_, z_;  // lines and levels of nodes
  int edge_ = 0;               // line at the tool's edge
  double depth_ = 0;
  std::vector<char> held_;
  Eigen::VectorXd u_, forces_;
  std::vector<Eigen::Triplet<double>> tangent_;
};

}  // namespace palpate

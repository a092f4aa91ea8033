// An elastic half-space under square cells of uniform load, and what a rigid sphere does to it.
//
// Compliances: K. L. Johnson, Contact Mechanics, 1985, eqs. 3.75 to 3.77 (a point force), over a
// square: his section 3.6. The sphere: his sections 4.2 (Hertz) and 7.2 (Cattaneo and Mindlin;
// Mindlin and Deresiewicz for a tangential force that turns back).
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace palpate::zone_tests {

// A rigid sphere on a half-space of moduli E = 1 and `nu`, with friction `mu`. Any unit of length.
struct SphereOnHalfSpace {
  double radius = 1, depth = 0, nu = 0.5, mu = 0;

  [[nodiscard]] double G() const { return 0.5 / (1 + nu); }
  [[nodiscard]] double a() const { return std::sqrt(radius * depth); }  // of the contact
  [[nodiscard]] double NormalForce() const {
    return 4.0 / 3 / (1 - nu * nu) * std::sqrt(radius) * std::pow(depth, 1.5);
  }
  // Tangential displacement at which all of it slides.
  [[nodiscard]] double SlidesAt() const {
    return 3 * mu * NormalForce() * (2 - nu) / (16 * a() * G());
  }
  // Tangential force at a displacement that grew from zero.
  [[nodiscard]] double Tangential(double displacement) const {
    const double left = std::max(0.0, 1 - displacement / SlidesAt());
    return mu * NormalForce() * (1 - std::pow(left, 1.5));
  }
  // The same after it grew to `farthest` and came back by twice the distance at most.
  [[nodiscard]] double TangentialBack(double displacement, double farthest) const {
    const double left = std::max(0.0, 1 - (farthest - displacement) / (2 * SlidesAt()));
    return Tangential(farthest) - 2 * mu * NormalForce() * (1 - std::pow(left, 1.5));
  }
  [[nodiscard]] double StickRadius(double tangential) const {
    return a() * std::cbrt(1 - tangential / (mu * NormalForce()));
  }
};

// Centres of the square cells of `side` whose distance from the origin is at most `reach`.
inline std::vector<Eigen::Vector3d> CellsWithin(double reach, double side) {
  const int most = static_cast<int>(reach / side);
  std::vector<Eigen::Vector3d> cells;
  for (int i = -most; i <= most; ++i) {
    for (int j = -most; j <= most; ++j) {
      const Eigen::Vector3d at(i * side, j * side, 0);
      if (at.norm() <= reach) cells.push_back(at);
    }
  }
  return cells;
}

// Displacement at `x`, `y`, `z` outward, by unit forces spread over a square cell around the
// origin, for nu = 0.5: what presses does not move a point sideways, nor the reverse.
inline Eigen::Matrix3d IncompressibleCell(double x, double y, double side) {
  constexpr double kG = 1.0 / 3, kNu = 0.5;
  double xx = 0, yy = 0, xy = 0;  // integrals of x^2 / r^3, y^2 / r^3, x y / r^3
  for (const double sx : {-0.5, 0.5}) {
    for (const double sy : {-0.5, 0.5}) {
      const double u = x + sx * side, v = y + sy * side, sign = sx * sy > 0 ? 1 : -1;
      xx += sign * v * std::asinh(u / std::abs(v));
      yy += sign * u * std::asinh(v / std::abs(u));
      xy -= sign * std::hypot(u, v);
    }
  }
  Eigen::Matrix3d W = Eigen::Matrix3d::Zero();
  W(0, 0) = (1 - kNu) * (xx + yy) + kNu * xx;
  W(1, 1) = (1 - kNu) * (xx + yy) + kNu * yy;
  W(0, 1) = W(1, 0) = kNu * xy;
  W(2, 2) = (1 - kNu) * (xx + yy);
  return W / (2 * M_PI * kG * side * side);
}

inline Eigen::MatrixXd ComplianceOf(const std::vector<Eigen::Vector3d>& cells, double side) {
  const auto count = static_cast<int>(cells.size());
  Eigen::MatrixXd W(3 * count, 3 * count);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      const Eigen::Vector3d from =
          cells[static_cast<std::size_t>(i)] - cells[static_cast<std::size_t>(j)];
      W.block<3, 3>(3 * i, 3 * j) = IncompressibleCell(from.x(), from.y(), side);
    }
  }
  return W;
}

}  // namespace palpate::zone_tests

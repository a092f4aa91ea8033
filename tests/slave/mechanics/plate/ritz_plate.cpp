#include "tests/slave/mechanics/plate/ritz_plate.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>

#include "shared/geometry/symmetric_eigen.h"

namespace palpate::plate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// (1 - r^2)^n x^i y^j and its derivatives.
struct Polynomial {
  int n = 1, i = 0, j = 0;
  struct Value {
    double f = 0, x = 0, y = 0, laplacian = 0;
  };
  [[nodiscard]] Value At(double x, double y) const {
    const double s = 1 - x * x - y * y;
    const auto power = [](double base, int e) { return e < 0 ? 0.0 : std::pow(base, e); };
    const double b = power(s, n), db = -n * power(s, n - 1), ddb = n * (n - 1) * power(s, n - 2);
    const double X = power(x, i), Y = power(y, j);
    const double Xx = i * power(x, i - 1), Yy = j * power(y, j - 1);
    const double Xxx = i * (i - 1) * power(x, i - 2), Yyy = j * (j - 1) * power(y, j - 2);
    const double r2 = x * x + y * y;
    return {b * X * Y, 2 * x * db * X * Y + b * Xx * Y, 2 * y * db * X * Y + b * X * Yy,
            (4 * r2 * ddb + 4 * db) * X * Y + 4 * db * (x * Xx * Y + y * X * Yy) +
                b * (Xxx * Y + X * Yyy)};
  }
};

std::vector<Polynomial> Polynomials(int n, int degree, int parity_of_y) {
  std::vector<Polynomial> all;
  for (int i = 0; i <= degree; ++i) {
    for (int j = parity_of_y; i + j <= degree; j += 2) all.push_back({n, i, j});
  }
  return all;
}

// Gauss-Legendre on (0, 1) by the eigenvalues of the Jacobi matrix.
void Gauss(int count, VectorXd* points, VectorXd* weights) {
  MatrixXd jacobi = MatrixXd::Zero(count, count);
  for (int k = 1; k < count; ++k) {
    jacobi(k, k - 1) = jacobi(k - 1, k) = k / std::sqrt(4.0 * k * k - 1);
  }
  const SymmetricEigen eigen = EigenOf(jacobi);
  *points = (1 + eigen.values.array()) / 2;
  *weights = eigen.vectors.row(0).cwiseAbs2();
}

}  // namespace

double RitzDeflection(double nu, double place, double load_radius, double force, int degree) {
  const auto w_basis = Polynomials(2, degree, 0);
  const auto u_basis = Polynomials(1, degree + 4, 0);
  const auto v_basis = Polynomials(1, degree + 4, 1);
  const auto nw = static_cast<Eigen::Index>(w_basis.size());
  const auto nu_count = static_cast<Eigen::Index>(u_basis.size());
  const Eigen::Index first_v = nw + nu_count;
  const Eigen::Index count = first_v + static_cast<Eigen::Index>(v_basis.size());
  const double D = 1 / (12 * (1 - nu * nu));
  Matrix3d C;
  C << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  C /= 1 - nu * nu;

  VectorXd r_points, r_weights;
  Gauss(degree + 8, &r_points, &r_weights);
  const int angles = 2 * degree + 12;  // on the upper half: the rest is its mirror image
  VectorXd load = VectorXd::Zero(count), at = VectorXd::Zero(count);
  for (Eigen::Index m = 0; m < nw; ++m) {
    const auto& f = w_basis[static_cast<std::size_t>(m)];
    at[m] = f.At(place, 0).f;
    for (Eigen::Index q = 0; q < r_points.size(); ++q) {
      const double r = load_radius * std::sqrt(r_points[q]);
      for (int k = 0; k < angles; ++k) {
        const double angle = 2 * std::numbers::pi * (k + 0.5) / angles;
        load[m] += r_weights[q] / angles * f.At(place + r * std::cos(angle), r * std::sin(angle)).f;
      }
    }
  }
  VectorXd a = VectorXd::Zero(count);
  for (int iteration = 0; iteration < 40; ++iteration) {
    VectorXd gradient = -std::min(1.0, (iteration + 1) / 4.0) * force * load;
    MatrixXd tangent = MatrixXd::Zero(count, count);
    MatrixXd B(3, count), slopes(2, nw);
    VectorXd laplacian(nw);
    for (Eigen::Index q = 0; q < r_points.size(); ++q) {
      for (int k = 0; k < angles; ++k) {
        const double r = r_points[q], angle = std::numbers::pi * (k + 0.5) / angles;
        const double weight = r_weights[q] * r * 2 * std::numbers::pi / angles;
        const double x = r * std::cos(angle), y = r * std::sin(angle);
        B.setZero();
        for (Eigen::Index m = 0; m < nw; ++m) {
          const auto f = w_basis[static_cast<std::size_t>(m)].At(x, y);
          slopes(0, m) = f.x;
          slopes(1, m) = f.y;
          laplacian[m] = f.laplacian;
        }
        for (Eigen::Index m = nw; m < count; ++m) {
          const bool is_u = m < first_v;
          const auto& g = is_u ? u_basis[static_cast<std::size_t>(m - nw)]
                               : v_basis[static_cast<std::size_t>(m - first_v)];
          const auto f = g.At(x, y);
          B(is_u ? 0 : 1, m) = is_u ? f.x : f.y;
          B(2, m) = is_u ? f.y : f.x;
        }
        const Eigen::Vector2d slope = slopes * a.head(nw);
        Vector3d strain = B * a;
        strain +=
            Vector3d(slope.x() * slope.x() / 2, slope.y() * slope.y() / 2, slope.x() * slope.y());
        B.topLeftCorner(1, nw) = slope.x() * slopes.row(0);
        B.block(1, 0, 1, nw) = slope.y() * slopes.row(1);
        B.block(2, 0, 1, nw) = slope.x() * slopes.row(1) + slope.y() * slopes.row(0);
        const Vector3d N = C * strain;
        Eigen::Matrix2d stress;
        stress << N[0], N[2], N[2], N[1];
        gradient += weight * (B.transpose() * N);
        gradient.head(nw) += weight * D * laplacian.dot(a.head(nw)) * laplacian;
        tangent.noalias() += weight * B.transpose() * (C * B);
        tangent.topLeftCorner(nw, nw).noalias() +=
            weight *
            (D * laplacian * laplacian.transpose() + slopes.transpose() * (stress * slopes));
      }
    }
    const VectorXd step = tangent.ldlt().solve(-gradient);
    a += step;
    if (iteration > 3 && step.norm() < 1e-9 * a.norm()) break;
  }
  return at.dot(a);
}

}  // namespace palpate::plate

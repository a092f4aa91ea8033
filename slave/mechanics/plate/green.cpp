#include "slave/mechanics/plate/green.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::plate {
namespace {

using Eigen::Vector2d;

constexpr double kUnit = 1 / (16 * std::numbers::pi);

// Terms of the formulas for a load at p and a point x:
//   R1^2 = |x - p|^2,   R2^2 = R1^2 + (1 - p^2)(1 - r^2),   Poisson's kernel (1 - p^2 r^2) / R2^2.
struct Pair {
  Pair(const Vector2d& p, const Vector2d& x)
      : inside_p(Inside(p)),
        inside_x(Inside(x)),
        R1_squared((x - p).squaredNorm()),
        R2_squared(R1_squared + inside_p * inside_x),
        poisson((inside_x + x.squaredNorm() * inside_p) / R2_squared) {}
  // 1 - r^2 without cancellation near the rim; zero beyond it.
  static double Inside(const Vector2d& x) {
    const double r = x.norm();
    return std::max(0.0, (1 - r) * (1 + r));
  }
  double inside_p, inside_x;
  double R1_squared, R2_squared;
  double poisson;
};

// Returns q - ln(1 + q) for q >= 0, accurate also where the two terms nearly cancel.
double MinusLog1p(double q) {
  if (q > 0.01) return q - std::log1p(q);
  double power = q * q;
  double sum = power / 2;
  for (int n = 3; n < 10; ++n) {
    power *= -q;
    sum += power / n;
  }
  return sum;
}

// The part of 16 pi w that is regular at the load: (1 - p^2)(1 - r^2) - R1^2 ln R2^2.
double Regular(const Pair& pair) {
  return pair.inside_p * pair.inside_x - pair.R1_squared * std::log(pair.R2_squared);
}

// Its Laplacian with respect to p: -8 - 4 ln R2^2 + 4 (1 - r^2) P, with Poisson's kernel P.
double RegularLaplacian(const Pair& pair) {
  return -8 - 4 * std::log(pair.R2_squared) + 4 * pair.inside_x * pair.poisson;
}

}  // namespace

double Deflection(const Vector2d& p, const Vector2d& x) noexcept {
  const Pair pair(p, x);
  const double clearance = pair.inside_p * pair.inside_x;
  if (clearance == 0) return 0;
  if (pair.R1_squared < 1e-300 * clearance) return kUnit * clearance;
  return kUnit * pair.R1_squared * MinusLog1p(clearance / pair.R1_squared);
}

double Deflection(const Disc& load, const Vector2d& x) noexcept {
  const double R = load.radius;
  if (R < 1e-150) return Deflection(load.centre, x);
  const Pair pair(load.centre, x);
  if (pair.inside_x == 0) return 0;
  const double d_squared = pair.R1_squared;
  const double R_squared = R * R;
  // Outside: w + R^2 / 8 times its Laplacian with respect to the load's place.
  if (d_squared >= R_squared) {
    const double q = pair.inside_p * pair.inside_x / d_squared;
    const double laplacian = pair.inside_x * pair.poisson - std::log1p(q);
    return kUnit * (d_squared * MinusLog1p(q) + R_squared / 2 * laplacian);
  }
  // Inside, the mean of d^2 ln d^2 over the disc satisfies Poisson's equation with the logarithmic
  // potential of a uniform disc on its right.
  const double log_R = std::log(R);
  const double singular = R_squared * (log_R - 0.25) + (2 * log_R + 1) * d_squared +
                          d_squared * (d_squared / R_squared) / 4;
  return kUnit * (Regular(pair) + R_squared / 8 * RegularLaplacian(pair) + singular);
}

}  // namespace palpate::plate

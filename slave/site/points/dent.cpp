#include "slave/site/points/dent.h"

#include <complex>

namespace palpate::site {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Where a point of the turned disc (tool on the x axis at `p`) lies in the press solved at `q`.
Vector2d Carried(const Vector2d& point, double p, double q, double rim) {
  if (p == q) return point;
  const double m = (p - q) * rim / (rim * rim - p * q);
  const std::complex<double> z(point.x() / rim, point.y() / rim);
  const std::complex<double> w = (z - m) / (1.0 - m * z);
  return rim * Vector2d(w.real(), w.imag());
}

}  // namespace

double ForceOf(const Dent& dent) noexcept {
  double force = 0;
  for (const Dent::Part& part : dent.parts) {
    if (part.press && part.share > 0) force += part.share * ForceAt(*part.press, dent.depth);
  }
  return force;
}

Vector3d DisplacementOf(const Dent& dent, const Vector2d& p_O) noexcept {
  if (!(p_O.norm() < dent.rim)) return Vector3d::Zero();
  const double p = dent.place_O.norm();
  const Vector2d axis = p > 0 ? Vector2d(dent.place_O / p) : Vector2d(1, 0);
  const Vector2d across(-axis.y(), axis.x());
  const Vector2d turned(axis.dot(p_O), across.dot(p_O));
  Vector3d u = Vector3d::Zero();
  for (const Dent::Part& part : dent.parts) {
    if (!part.press || !(part.share > 0)) continue;
    u += part.share *
         DisplacementAt(*part.press, Carried(turned, p, part.radius, dent.rim), dent.depth);
  }
  Vector3d u_O;
  u_O << u.x() * axis + u.y() * across, u.z();
  return u_O;
}

}  // namespace palpate::site

// The clamped plate's Green's functions: laws first, then the reference cases.
#include "slave/mechanics/plate/green.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace palpate::plate {
namespace {

using Eigen::Vector2d;

Vector2d Polar(double r, double angle) {
  return {r * std::cos(angle), r * std::sin(angle)};
}

// Reference: the clamped edge: w and dw/dn vanish. w ~ (1 - r)^2 there: at 1 - r = e the slope by
// a one-sided difference is e times a curvature of order one.
TEST(Green, TheEdgeIsClamped) {
  for (const double R : {0.0, 0.2}) {
    const Disc load{{0.5, 0}, R};
    for (const double angle : {0.0, 1.0, 3.0}) {
      EXPECT_NEAR(Deflection(load, Polar(1, angle)), 0, 1e-30);
      for (const double e : {1e-3, 1e-5}) {
        EXPECT_LT(Deflection(load, Polar(1 - e, angle)), e * e);
        EXPECT_GT(Deflection(load, Polar(1 - e, angle)), 0);
      }
    }
  }
}

// Mean over a disc by a rule of rings and angles, for smooth integrands.
template <typename F>
double MeanOver(const Disc& disc, int rings, const F& f) {
  double sum = 0;
  const int angles = 4 * rings;
  for (int i = 0; i < rings; ++i) {
    // Midpoints in r^2: second order where f has a kink, much better where it is smooth.
    const double r = disc.radius * std::sqrt((i + 0.5) / rings);
    for (int k = 0; k < angles; ++k) {
      sum += f(Vector2d(disc.centre + Polar(r, 2 * std::numbers::pi * (k + 0.5) / angles)));
    }
  }
  return sum / (rings * angles);
}

// Reference: the mean of point loads over the disc, by quadrature of second order: with 200 rings
// the error is 1e-5 at most, inside the disc, outside it, across its edge and near the rim.
TEST(Green, ADiscLoadIsTheMeanOfPointLoads) {
  for (const Disc& load : {Disc{{0.3, 0.2}, 0.15}, Disc{{0, 0}, 0.4}, Disc{{-0.85, 0}, 0.149}}) {
    for (const double r : {0.0, 0.5, 1.0, 1.5}) {
      const Vector2d x = load.centre + r * load.radius * Vector2d(0.6, 0.8);
      if (x.norm() > 0.999) continue;
      const double mean = MeanOver(load, 200, [&](const Vector2d& p) { return Deflection(p, x); });
      EXPECT_NEAR(Deflection(load, x) / mean, 1, 1e-5) << load.centre.x() << " " << r;
    }
  }
}

// Reference: the point load, from which a disc differs by R^2 ln R.
TEST(Green, SmallDiscsBecomePoints) {
  const Vector2d p(0.35, -0.4);
  const double point = Deflection(p, p);
  for (const double R : {1e-3, 1e-6, 1e-12, 1e-100, 1e-160, 0.0}) {
    const double w = Deflection(Disc{p, R}, p);
    EXPECT_NEAR(w, point, 2 * R * R * std::abs(std::log(R + 1e-300)) + 1e-16) << R;
  }
}

// Reference: w at the load = (1 - p^2)^2 / (16 pi), to rounding up to the rim itself.
TEST(Green, LoadsNearTheRimKeepTheirDigits) {
  for (const double e : {1e-2, 1e-5, 1e-8}) {
    const Vector2d p(0, 1 - e);
    const double r = p.norm();
    const double inside = (1 - r) * (1 + r);
    EXPECT_NEAR(Deflection(p, p) * 16 * std::numbers::pi / (inside * inside), 1, 1e-13);
  }
  EXPECT_EQ(Deflection(Vector2d(1, 0), Vector2d(1, 0)), 0);
}

}  // namespace
}  // namespace palpate::plate

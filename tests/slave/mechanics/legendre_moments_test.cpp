#include <array>
#include <cmath>
#include <complex>
#include <functional>

#include <gtest/gtest.h>

#include "slave/mechanics/bem/element_nodes.h"

namespace palpate {
namespace {

using Complex = std::complex<double>;

double Legendre(std::size_t k, double s) {
  return k == 0 ? 1 : k == 1 ? s : 1.5 * s * s - 0.5;
}

// Five points of Gauss's rule on parts that halve towards the place nearest to z.
Complex Graded(const std::function<Complex(double)>& f, double a, double b, double near,
               int depth) {
  static constexpr std::array<double, 5> kPlace{0, 0.5384693101056831, -0.5384693101056831,
                                                0.9061798459386640, -0.9061798459386640};
  static constexpr std::array<double, 5> kWeight{0.5688888888888889, 0.4786286704993665,
                                                 0.4786286704993665, 0.2369268850561891,
                                                 0.2369268850561891};
  const bool far = depth == 0 || (b - a) < 0.1 * std::max(a - near, near - b);
  if (far) {
    Complex sum = 0;
    for (std::size_t q = 0; q < kPlace.size(); ++q) {
      sum += 0.5 * (b - a) * kWeight[q] * f(0.5 * (a + b) + 0.5 * (b - a) * kPlace[q]);
    }
    return sum;
  }
  const double middle = 0.5 * (a + b);
  return Graded(f, a, middle, near, depth - 1) + Graded(f, middle, b, near, depth - 1);
}

// Reference: the definitions by quadrature. Near the element, far from it, and on both sides of the
// distances at which the way of computing changes. Tolerance: relative to the moment of a constant,
// the quadrature's own 1e-12; a hundredth from the element the third power has lost two digits
// more, and the difference of logarithms keeps 1e-16 of itself.
TEST(LegendreMoments, AreTheIntegralsTheyStandFor) {
  for (const double distance : {0.01, 0.3, 1.0, 1.99, 2.01, 5.0, 7.99, 8.01, 40.0, 1e4}) {
    for (const double angle : {0.2, 1.3, 1.57, 2.9, -0.7, -2.0}) {
      const Complex z = 0.4 * (distance < 1 ? 1 : 0) + std::polar(distance, angle);
      const LegendreMoments moments(z);
      const double near = std::clamp(z.real(), -1.0, 1.0);
      std::array<double, 4> scale{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto integral = [&](const std::function<Complex(double)>& kernel) {
          return Graded([&](double s) { return Legendre(k, s) * kernel(s); }, -1, 1, near, 14);
        };
        const Complex log = integral([&](double s) { return std::log(z - s) - std::log(z); });
        const Complex pole = integral([&](double s) { return 1.0 / (s - z); });
        const Complex dipole = integral([&](double s) { return 1.0 / ((s - z) * (s - z)); });
        const Complex triple =
            integral([&](double s) { return 2.0 / ((s - z) * (s - z) * (s - z)); });
        const auto size = [&](std::size_t what, const Complex& value) {
          return scale[what] = std::max(scale[what], std::abs(value));
        };
        EXPECT_LT(std::abs(moments.pole[k] - pole), 2e-12 * size(1, pole)) << z << k;
        EXPECT_LT(std::abs(moments.dipole[k] - dipole), 2e-12 * size(2, dipole)) << z << k;
        EXPECT_LT(std::abs(moments.triple[k] - triple), 2e-10 * size(3, triple)) << z << k;
        if (k > 0) {
          EXPECT_LT(std::abs(moments.log[k].real() - log.real()), 2e-12 * size(0, pole) + 1e-15)
              << z << k;
        }
      }
    }
  }
}

// Reference: Cauchy's principal values by hand, ln((1 - x) / (1 + x)) for a constant.
TEST(LegendreMoments, ArePrincipalValuesOnTheElement) {
  for (const double x : {-0.7745966692414834, 0.0, 0.5773502691896257}) {
    const LegendreMoments moments(Complex(x, -0.0));
    const double constant = std::log((1 - x) / (1 + x));
    EXPECT_NEAR(moments.pole[0].real(), constant, 1e-15);
    EXPECT_NEAR(moments.pole[1].real(), 2 + x * constant, 1e-15);
    EXPECT_NEAR(moments.pole[2].real(), 3 * x + Legendre(2, x) * constant, 1e-15);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(moments.pole[k].imag(), 0);
      EXPECT_EQ(moments.dipole[k], 0.0);
    }
  }
}

}  // namespace
}  // namespace palpate

#include "slave/mechanics/bem/element_nodes.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "slave/mesh/index.h"

namespace palpate {
namespace {

// The nodes integrate products of two basis functions exactly: a function's component along P_k is
// its weighted sum over the nodes, times 2 k + 1.
ElementNodes WithModes(ElementNodes nodes) {
  for (std::size_t m = 0; m < Index(nodes.count); ++m) {
    for (std::size_t k = 0; k < Index(nodes.count); ++k) {
      nodes.mode[m][k] = (2 * static_cast<double>(k) + 1) * nodes.weight[m] *
                         ElementNodes::Legendre(static_cast<int>(k), nodes.s[m]);
    }
  }
  return nodes;
}

using Complex = LegendreMoments::Complex;

constexpr std::size_t kFunctions = kModes + 1;
// |z| from which quadrature is used, because the recurrence loses accuracy as |z|^4.
constexpr double kFar = 2;
constexpr int kFarPoints = 14;  // (2 + sqrt 3)^(-2 * 14) = 1e-16
constexpr double kVeryFar = 8;
constexpr int kVeryFarPoints = 7;  // 16^(-2 * 7) = 1e-17

struct QuadraturePoint {
  double s;
  std::array<double, kFunctions> weighted;  // weight times P_k(s)
};
using Rule = std::vector<QuadraturePoint>;

// P_k for k up to `count` at s.
std::vector<double> Polynomials(int count, double s) {
  std::vector<double> p{1, s};
  for (int k = 1; k < count; ++k) {
    const auto last = Index(k);
    p.push_back(((2 * k + 1) * s * p[last] - k * p[last - 1]) / (k + 1));
  }
  return p;
}

// Gauss's rule: the roots of P_count by Newton's iteration.
Rule GaussRule(int count) {
  Rule rule;
  for (int i = 0; i < count; ++i) {
    double s = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double slope = 1;
    for (int step = 0; step < 6; ++step) {
      const auto p = Polynomials(count, s);
      slope = count * (s * p[p.size() - 1] - p[p.size() - 2]) / (s * s - 1);
      s -= p.back() / slope;
    }
    const double weight = 2 / ((1 - s * s) * slope * slope);
    const auto p = Polynomials(count, s);
    rule.push_back({s, {weight, weight * p[1], weight * p[2], weight * p[3], weight * p[4]}});
  }
  return rule;
}

// 1 / z without the checks for infinities that the library's division makes.
Complex Inverse(const Complex& z) {
  const double scale = 1 / (z.real() * z.real() + z.imag() * z.imag());
  return {z.real() * scale, -z.imag() * scale};
}

Complex Times(const Complex& a, const Complex& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

using Functions = std::array<Complex, kFunctions>;

Functions ByRecurrence(const Complex& z, bool on_element) {
  Functions Q;
  Q[0] = on_element ? Complex(std::atanh(z.real()), 0) : 0.5 * std::log((z + 1.0) / (z - 1.0));
  Q[1] = Times(z, Q[0]) - 1.0;
  for (std::size_t k = 1; k + 1 < kFunctions; ++k) {
    const auto order = static_cast<double>(k);
    Q[k + 1] = ((2 * order + 1) * Times(z, Q[k]) - order * Q[k - 1]) / (order + 1);
  }
  return Q;
}

// Q' follows from the recurrence and Q'' from Legendre's equation; both divide by z^2 - 1.
void Differentiate(const Complex& z, const Functions& Q, LegendreMoments* m) {
  const Complex inverse = Inverse(Times(z, z) - 1.0);
  for (std::size_t k = 0; k < kModes; ++k) {
    const auto order = static_cast<double>(k);
    const Complex slope = k == 0 ? -inverse : order * Times(Times(z, Q[k]) - Q[k - 1], inverse);
    m->dipole[k] = -2.0 * slope;
    m->triple[k] = -2.0 * Times(order * (order + 1) * Q[k] - 2.0 * Times(z, slope), inverse);
  }
}

Functions ByQuadrature(const Rule& rule, const Complex& z, LegendreMoments* m) {
  Functions Q{};
  for (const auto& point : rule) {
    const Complex inverse = Inverse(z - point.s);
    const Complex square = Times(inverse, inverse);
    const Complex cube = Times(square, inverse);
    for (std::size_t k = 0; k < kFunctions; ++k) Q[k] += 0.5 * point.weighted[k] * inverse;
    for (std::size_t k = 0; k < kModes; ++k) {
      m->dipole[k] += point.weighted[k] * square;
      m->triple[k] -= 2 * point.weighted[k] * cube;
    }
  }
  return Q;
}

}  // namespace

const ElementNodes& ElementNodes::Of(ElementOrder order) {
  static const double third = 1 / std::sqrt(3.0);
  static const double fifth = std::sqrt(0.6);
  static const ElementNodes constant = WithModes({1, {0}, {1}, {}});
  static const ElementNodes linear = WithModes({2, {-third, third}, {0.5, 0.5}, {}});
  static const ElementNodes quadratic =
      WithModes({3, {-fifth, 0, fifth}, {5.0 / 18, 8.0 / 18, 5.0 / 18}, {}});
  return order == ElementOrder::kConstant ? constant
         : order == ElementOrder::kLinear ? linear
                                          : quadratic;
}

LegendreMoments::LegendreMoments(Complex z) {
  static const Rule far = GaussRule(kFarPoints);
  static const Rule very_far = GaussRule(kVeryFarPoints);
  const double distance = std::norm(z);
  Functions Q;
  if (distance > kFar * kFar) {
    Q = ByQuadrature(distance > kVeryFar * kVeryFar ? very_far : far, z, this);
  } else {
    const bool on_element = z.imag() == 0 && std::abs(z.real()) < 1;
    Q = ByRecurrence(z, on_element);
    if (!on_element) Differentiate(z, Q, this);
  }
  for (std::size_t k = 0; k < kModes; ++k) {
    pole[k] = -2.0 * Q[k];
    if (k > 0) log[k] = 2 / (2 * static_cast<double>(k) + 1) * (Q[k + 1] - Q[k - 1]);
  }
}

}  // namespace palpate

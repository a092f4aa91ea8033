#include "slave/mechanics/plate/lobatto.h"

#include <cmath>
#include <numbers>

namespace palpate::plate {
namespace {

// Legendre's polynomial of degree n on [-1, 1]; its slope and curvature, for |x| < 1 only.
struct Legendre {
  Legendre(int n, double x) {
    double before = 1;
    value = n == 0 ? 1 : x;
    for (int k = 2; k <= n; ++k) {
      const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
      before = value;
      value = next;
    }
    slope = n == 0 ? 0 : n * (x * value - before) / (x * x - 1);
    curvature = (2 * x * slope - n * (n + 1) * value) / (1 - x * x);
  }
  double value, slope, curvature;
};

}  // namespace

Quadrature GaussLegendre(int count) {
  Quadrature rule{Eigen::VectorXd(count), Eigen::VectorXd(count)};
  for (int i = 0; i < count; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    for (int step = 0; step < 8; ++step) {
      const Legendre p(count, x);
      x -= p.value / p.slope;
    }
    const double slope = Legendre(count, x).slope;
    rule.points[i] = (1 + x) / 2;
    rule.weights[i] = 1 / ((1 - x * x) * slope * slope);
  }
  return rule;
}

Eigen::VectorXd LobattoPoints(int count) {
  Eigen::VectorXd points(count);
  points[0] = 0;
  points[count - 1] = 1;
  for (int i = 1; i + 1 < count; ++i) {
    double x = -std::cos(std::numbers::pi * i / (count - 1));
    for (int step = 0; step < 10; ++step) {
      const Legendre p(count - 1, x);
      x -= p.slope / p.curvature;
    }
    points[i] = (1 + x) / 2;
  }
  return points;
}

Interpolation Interpolate(const Eigen::VectorXd& nodes, const Eigen::VectorXd& places) {
  Interpolation result{Eigen::MatrixXd::Zero(places.size(), nodes.size()),
                       Eigen::MatrixXd::Zero(places.size(), nodes.size())};
  for (Eigen::Index q = 0; q < places.size(); ++q) {
    for (Eigen::Index i = 0; i < nodes.size(); ++i) {
      double value = 1;
      double slope = 0;
      for (Eigen::Index j = 0; j < nodes.size(); ++j) {
        if (j == i) continue;
        const double scale = 1 / (nodes[i] - nodes[j]);
        slope = (slope * (places[q] - nodes[j]) + value) * scale;
        value *= (places[q] - nodes[j]) * scale;
      }
      result.value(q, i) = value;
      result.slope(q, i) = slope;
    }
  }
  return result;
}

}  // namespace palpate::plate

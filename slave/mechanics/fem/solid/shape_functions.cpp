#include "slave/mechanics/fem/solid/shape_functions.h"

#include <array>

namespace palpate {

using Eigen::Vector4d;

std::span<const QuadraturePoint> QuadratureOf(int nodes_per_element) {
  static const std::array<QuadraturePoint, 1> kCentre{{{Vector4d::Constant(0.25), 1}}};
  constexpr double kNear = 0.58541019662496845446, kFar = 0.13819660112501051518;
  static const std::array<QuadraturePoint, 4> kFour{{{Vector4d(kNear, kFar, kFar, kFar), 0.25},
                                                     {Vector4d(kFar, kNear, kFar, kFar), 0.25},
                                                     {Vector4d(kFar, kFar, kNear, kFar), 0.25},
                                                     {Vector4d(kFar, kFar, kFar, kNear), 0.25}}};
  if (nodes_per_element == 4) return kCentre;
  return kFour;
}

ShapeValues ShapesAt(int nodes_per_element, const Vector4d& bary) {
  if (nodes_per_element == 4) return bary;
  ShapeValues shapes(10);
  for (int i = 0; i < 4; ++i) shapes[i] = bary[i] * (2 * bary[i] - 1);
  for (int e = 0; e < 6; ++e) {
    const auto [a, b] = kTetEdges[Index(e)];
    shapes[4 + e] = 4 * bary[a] * bary[b];
  }
  return shapes;
}

ShapeValues ShapeIntegrals(int nodes_per_element) {
  if (nodes_per_element == 4) return ShapeValues::Constant(4, 0.25);
  ShapeValues integrals(10);
  integrals << Vector4d::Constant(-1.0 / 20), Eigen::Matrix<double, 6, 1>::Constant(1.0 / 5);
  return integrals;
}

Eigen::MatrixXd ShapeProducts(int nodes_per_element) {
  if (nodes_per_element == 4) return (Eigen::Matrix4d::Ones() + Eigen::Matrix4d::Identity()) / 20;
  Eigen::MatrixXd products(10, 10);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) products(i, j) = i == j ? 6 : 1;
    for (int e = 0; e < 6; ++e) {
      const auto [a, b] = kTetEdges[Index(e)];
      products(i, 4 + e) = products(4 + e, i) = i == a || i == b ? -4 : -6;
    }
  }
  for (int e = 0; e < 6; ++e) {
    for (int f = 0; f < 6; ++f) {
      const auto [a, b] = kTetEdges[Index(e)];
      const auto [c, d] = kTetEdges[Index(f)];
      const int shared = (a == c || a == d) + (b == c || b == d);
      products(4 + e, 4 + f) = shared == 2 ? 32 : shared == 1 ? 16 : 8;
    }
  }
  return products / 420;
}

}  // namespace palpate

#include <array>
#include <functional>

#include <gtest/gtest.h>

#include "slave/mechanics/membrane/inflated_membrane.h"

namespace palpate {
namespace {

using Nine = Eigen::Matrix<double, 9, 1>;

const std::array<Eigen::Vector3d, 3> kCorners{
    Eigen::Vector3d(0.1, 0.2, 0.9), Eigen::Vector3d(1.3, 0.1, 0.7), Eigen::Vector3d(0.4, 1.1, 1.2)};

Nine Stacked(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& field) {
  Nine u;
  for (int k = 0; k < 3; ++k) u.segment<3>(3 * k) = field(kCorners[static_cast<std::size_t>(k)]);
  return u;
}

// Reference: the volume itself, a polynomial of third degree: central differences of its gradient
// are exact but for rounding.
TEST(MembraneTriangle, TheSecondDerivativeOfTheVolumeIsThatOfTheVolume) {
  const auto volume = [](const Nine& p) {
    return p.segment<3>(0).dot(p.segment<3>(3).cross(p.segment<3>(6))) / 6;
  };
  const Nine p = Stacked([](const Eigen::Vector3d& x) { return x; });
  const TriangleMatrix H = MembraneTriangle(kCorners).Volume();
  const double h = 1e-3;
  for (int i = 0; i < 9; ++i) {
    for (int j = 0; j < 9; ++j) {
      const Nine ei = h * Nine::Unit(i);
      const Nine ej = h * Nine::Unit(j);
      const double difference =
          (volume(p + ei + ej) - volume(p + ei - ej) - volume(p - ei + ej) + volume(p - ei - ej)) /
          (4 * h * h);
      EXPECT_NEAR(H(i, j), difference, 1e-9) << i << " " << j;
    }
  }
}

// Reference: no energy from a small rigid motion, and that of a uniform stretch in the plane,
// A / (1 - nu) e^2 per E h, and of a shear, A / (4 (1 + nu)) gamma^2.
TEST(MembraneTriangle, ElasticEnergyIsThatOfTheStrain) {
  const MembraneTriangle triangle(kCorners);
  const TriangleMatrix K = triangle.Elastic(0.3);
  const Eigen::Vector3d omega(0.3, -0.5, 0.8);
  const Nine turned =
      Stacked([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(omega.cross(x) + omega); });
  EXPECT_NEAR(turned.dot(K * turned), 0, 1e-14);
  const Eigen::Vector3d n = triangle.normal();
  const Nine stretched =
      Stacked([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.01 * (x - n * n.dot(x))); });
  EXPECT_NEAR(stretched.dot(K * stretched) / 2, triangle.area() * 1e-4 / (1 - 0.3), 1e-14);
  const Eigen::Vector3d e1 = n.unitOrthogonal();
  const Eigen::Vector3d e2 = n.cross(e1);
  const Nine sheared =
      Stacked([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.01 * e2.dot(x) * e1); });
  EXPECT_NEAR(sheared.dot(K * sheared) / 2, triangle.area() * 1e-4 / (4 * (1 + 0.3)), 1e-14);
}

// Reference: int |grad w|^2 of a linear field of slope s in the plane, along the normal: A s^2.
TEST(MembraneTriangle, TensionCountsTheSlope) {
  const MembraneTriangle triangle(kCorners);
  const TriangleMatrix K = triangle.Tension();
  const Eigen::Vector3d n = triangle.normal();
  const Eigen::Vector3d e = n.unitOrthogonal();
  const Nine tilted =
      Stacked([&](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.2 * e.dot(x) * n); });
  EXPECT_NEAR(tilted.dot(K * tilted), triangle.area() * 0.04, 1e-14);
}

}  // namespace
}  // namespace palpate

#include <cmath>

#include <gtest/gtest.h>

#include "slave/study/press_spec.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

SurfaceMesh CubeSurface(int cells) {
  return SurfaceOf(MeshBox({0.06, 0.06, 0.06}, {cells, cells, cells}));
}

template <typename Field>
double Mean(const std::vector<LoadPoint>& points, const Field& field) {
  double sum = 0;
  for (const LoadPoint& point : points) sum += point.share * field(point.p_O);
  return sum;
}

constexpr double kRadius = 0.011;
const Vector3d kPlace(0.029, 0.031, 0.06);

// Reference: means over a disc of radius a: 1, the centre, and of x^2 about it a^2 / 4. Tolerance:
// with steps of a 64th of an edge the error of the disc's moments is 1e-3 on the coarsest mesh;
// measured 3e-4.
TEST(RoundLoadTest, MeansOverTheDiscAreTheDiscs) {
  for (const int cells : {3, 7, 12}) {
    for (const bool quadratic : {false, true}) {
      const auto points =
          RoundLoad(CubeSurface(cells), kPlace, -Vector3d::UnitZ(), 2 * kRadius, quadratic);
      EXPECT_NEAR(Mean(points, [](const Vector3d&) { return 1; }), 1, 1e-12);
      EXPECT_NEAR(Mean(points, [](const Vector3d& p) { return p.x(); }), kPlace.x(),
                  1e-3 * kRadius);
      EXPECT_NEAR(Mean(points, [](const Vector3d& p) { return p.y(); }), kPlace.y(),
                  1e-3 * kRadius);
      EXPECT_NEAR(Mean(points, [](const Vector3d& p) { return p.z(); }), 0.06, 1e-12);
    }
  }
}

// With `quadratic`, second moments too: the nodes' shares are those of the quadratic shape
// functions, whose interpolation of x^2 is exact.
TEST(RoundLoadTest, QuadraticSharesKeepSecondMoments) {
  const double wanted = kRadius * kRadius / 4;
  for (const int cells : {3, 7, 12}) {
    const auto points =
        RoundLoad(CubeSurface(cells), kPlace, -Vector3d::UnitZ(), 2 * kRadius, true);
    const auto second = [](const Vector3d& p) { return std::pow(p.x() - kPlace.x(), 2); };
    EXPECT_NEAR(Mean(points, second) / wanted, 1, 2e-3) << cells;
    const auto mixed = [](const Vector3d& p) {
      return (p.x() - kPlace.x()) * (p.y() - kPlace.y());
    };
    EXPECT_NEAR(Mean(points, mixed) / wanted, 0, 2e-3) << cells;
  }
}

}  // namespace
}  // namespace palpate::study

#include "slave/mechanics/bem/interior_field.h"

#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Uniform tension of a block that nothing holds: s_xx = s, all else zero.
class TensionTest : public testing::TestWithParam<std::pair<Plane, double>> {
 protected:
  static constexpr double kTension = 1000, kModulus = 2e5;
  TensionTest()
      : mesh_(MeshRectangle(0.2, 0.1, 120)),
        model_(bodies::Free(mesh_, GetParam().second, GetParam().first),
               {.young_modulus = kModulus, .thickness = 1}) {
    std::vector<Contact> loads;
    for (int i = 0; i < mesh_.size(); ++i) {
      const auto& e = mesh_.elements[static_cast<std::size_t>(i)];
      if (std::abs(e.normal().x()) < 0.5) continue;
      loads.push_back(bodies::Load(i, {kTension * e.length() * e.normal().x(), 0}));
    }
    valid_ = bodies::Respond(model_, loads, &solution_).front().validity == Validity::kValid;
  }
  BoundaryMesh mesh_;
  Bem2dModel model_;
  Solution solution_;
  bool valid_ = false;
};

// Reference: the exact uniform stress, also at nu = 0.5 where Hooke's law from strains alone has
// lost the pressure. Tolerance: constant elements at this resolution, 1 % of the tension.
TEST_P(TensionTest, StressInsideIsUniform) {
  ASSERT_TRUE(valid_);
  const InteriorField field(model_, model_.Boundary(solution_));
  const Matrix2d expected = (Matrix2d() << kTension, 0, 0, 0).finished();
  for (const Vector2d& p : {Vector2d(0.1, 0.05), Vector2d(0.03, 0.02), Vector2d(0.17, 0.08)}) {
    EXPECT_LT((field.At(p).stress - expected).norm(), 0.01 * kTension) << p.transpose();
  }
}

// Reference: as above; along the free sides the tension is all there is.
TEST_P(TensionTest, StressAlongTheBoundaryIsTheTension) {
  const InteriorField field(model_, model_.Boundary(solution_));
  const Matrix2d stress = field.OnBoundary(20).stress;  // middle of the lower side
  EXPECT_NEAR(stress(0, 0), kTension, 0.02 * kTension);
  EXPECT_NEAR(stress(1, 1), 0, 1e-9 * kTension);
}

INSTANTIATE_TEST_SUITE_P(Materials, TensionTest,
                         testing::Values(std::pair{Plane::kStress, 0.3},
                                         std::pair{Plane::kStress, 0.5},
                                         std::pair{Plane::kStrain, 0.3},
                                         std::pair{Plane::kStrain, 0.5}));

}  // namespace
}  // namespace palpate

#include "slave/mechanics/bem/greens_functions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/mechanics/bodies.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Matrix2d;

Matrix2d Block(const GreensFunctions& greens, int i, int j) {
  return Eigen::Map<const Matrix2d>(greens.block(i, j));
}

// Reference: constant elements carry a rigid translation exactly. Moving all held elements together
// moves everything with them and needs no reaction.
TEST(GreensFunctions, CarryARigidTranslationWithoutForce) {
  for (const double nu : {0.0, 0.3, 0.5}) {
    const GreensFunctions greens(bodies::Block(60, 1, nu));
    for (int i = 0; i < greens.size(); ++i) {
      Matrix2d sum = Matrix2d::Zero();
      for (int j = 0; j < greens.size(); ++j) {
        if (greens.held(j, 0)) sum += Block(greens, i, j);
      }
      const Matrix2d expected = (greens.held(i, 0) ? 0.0 : 1.0) * Matrix2d::Identity();
      EXPECT_LT((sum - expected).norm(), 1e-11) << "element " << i << ", nu = " << nu;
    }
  }
}

TEST(GreensFunctions, CountTheRigidMotionsThatAreLeftFree) {
  ReferenceProblem problem = bodies::Block(40);
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 0);
  for (auto& held : problem.held) held[1] = false;  // x held along the bottom: y and turning remain
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 2);
  for (auto& held : problem.held) held = {false, false};
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 3);
  problem.held[3] = {true, true};  // a held element does not turn
  EXPECT_EQ(GreensFunctions(problem).free_motions(), 0);
}

std::string RefusalOf(const ReferenceProblem& problem) {
  return Thrown<std::invalid_argument>([&] { const GreensFunctions greens(problem); });
}

TEST(GreensFunctions, RefuseWhatPlaneStrainCannotKnowNearNuOneHalf) {
  ReferenceProblem all_held = bodies::Free(MeshDisc(1, 20), 0.5, Plane::kStrain);
  for (auto& held : all_held.held) held = {true, true};
  EXPECT_THAT(RefusalOf(all_held), testing::HasSubstr("whole boundary"));
  all_held.nu = 0.49;
  EXPECT_EQ(RefusalOf(all_held), "");
}

TEST(GreensFunctions, RefuseUnusableMeshesAndConstants) {
  ReferenceProblem problem = bodies::Block(8);
  problem.nu = 0.51;
  EXPECT_THAT(RefusalOf(problem), testing::HasSubstr("-1 < nu <= 0.5"));
  problem.nu = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(RefusalOf(problem), testing::HasSubstr("-1 < nu <= 0.5"));
  problem = bodies::Block(8);
  problem.mesh.elements[2].b = problem.mesh.elements[2].a;
  EXPECT_THAT(RefusalOf(problem), testing::HasSubstr("without length"));
  problem = bodies::Block(8);
  problem.mesh.elements.resize(2);
  EXPECT_THAT(RefusalOf(problem), testing::HasSubstr("3 or more"));
  problem = bodies::Block(8);
  problem.mesh.length_unit = 0;
  EXPECT_THAT(RefusalOf(problem), testing::HasSubstr("length unit"));
  problem = bodies::Block(8);
  problem.mesh.elements[1] = problem.mesh.elements[0];  // held twice at one place
  EXPECT_THAT(RefusalOf(problem), testing::HasSubstr("singular"));
}

}  // namespace
}  // namespace palpate

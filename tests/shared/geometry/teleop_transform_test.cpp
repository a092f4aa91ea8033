#include "shared/geometry/teleop_transform.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/support/references.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

TeleopTransform Example() {
  TeleopTransform transform{0.02, 350.0, Eigen::Matrix3d::Identity(), {0.01, -0.02, 0.005}};
  transform.R_SM = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return transform;
}

TEST(TeleopTransformTest, PositionsGoThereAndBack) {
  const TeleopTransform transform = Example();
  const Vector3d p_M(0.03, 0.01, -0.02);
  EXPECT_LT((transform.ToMaster(transform.ToSlave(p_M)) - p_M).norm(), 1e-14);
}

// Virtual work: F_M . dp_M = (s_F / s_p) F_S . dp_S for every motion, which fixes T^F given T^p.
TEST(TeleopTransformTest, PowerScalesWithTheRatioOfTheScales) {
  const TeleopTransform transform = Example();
  const Vector3d f_S(0.001, 0.002, -0.0005), v_M(0.1, -0.2, 0.05);
  const double power_M = transform.ForceToMaster(f_S).dot(v_M);
  const double power_S = f_S.dot(transform.VelocityToSlave(v_M));
  EXPECT_NEAR(power_M / power_S, 350.0 / 0.02, 1e-8);
}

TEST(TeleopTransformTest, ZeroingTheOffsetMakesEngagingMoveNothing) {
  TeleopTransform transform = Example();
  const Vector3d p_M(0.4, -0.3, 0.2), p_S(0.044, 0.094, 0);
  transform.ZeroOffset(p_M, p_S);
  EXPECT_LT((transform.ToSlave(p_M) - p_S).norm(), 1e-15);
}

// Reference f, case scaling_transform, with its own tolerance 1e-12.
TEST(TeleopTransformTest, ReproducesTheReferenceCase) {
  PALPATE_CASE_OR_SKIP(c, "f_interpolation_scaling.json", "scaling_transform");
  const auto& p = c["params"];
  const auto vector = reference::VectorOf;
  TeleopTransform transform;
  transform.position_scale = p["s_p"];
  transform.force_scale = p["s_F"];
  for (int row = 0; row < 3; ++row) transform.R_SM.row(row) = vector(p["R_rows"][row]);
  transform.offset = vector(p["offset_m"]);
  const Vector3d p_S = vector(c["expected"]["p_slave_m"]);
  const Vector3d f_M = vector(c["expected"]["F_master_N"]);
  EXPECT_LT((transform.ToSlave(vector(p["p_master_m"])) - p_S).norm(), 1e-12);
  EXPECT_LT((transform.ForceToMaster(vector(p["F_slave_N"])) - f_M).norm(), 1e-12);
}

}  // namespace
}  // namespace palpate

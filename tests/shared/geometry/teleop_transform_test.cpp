#include "shared/geometry/teleop_transform.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "tests/support/dice.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

Eigen::Quaterniond AnyRotation(Dice* dice) {
  return Eigen::Quaterniond(dice->Normal(), dice->Normal(), dice->Normal(), dice->Normal())
      .normalized();
}

// Laws: the inverse of position and rotation; no rotation at the beginning of the engagement; a
// rotation of the device about an axis of M rotates the tool by the same angle about that axis in
// S; a quaternion and its negative are the same rotation.
TEST(TeleopTransformTest, PositionsAndRotationsGoThereAndBack) {
  Dice dice(7);
  for (int i = 0; i < 2000; ++i) {
    const auto any = [&] { return Vector3d(dice.Normal(), dice.Normal(), dice.Normal()); };
    TeleopTransform transform{dice.Decades(1e-3, 1e2), dice.Decades(1e-3, 1e3)};
    transform.R_SM = AnyRotation(&dice).toRotationMatrix();
    const Vector3d p_M = any(), p_S = any();
    transform.ZeroOffset(any(), p_S);
    const double size = p_S.norm() + transform.position_scale;
    EXPECT_LT((transform.ToMaster(transform.ToSlave(p_M)) - p_M).norm() * transform.position_scale,
              1e-13 * size);
    transform.begin = {AnyRotation(&dice), AnyRotation(&dice)};
    const auto& [R_M0, R_S0] = *transform.begin;
    EXPECT_LT(transform.RotationToSlave(R_M0).angularDistance(R_S0), 1e-7);
    const Eigen::Quaterniond R_M = AnyRotation(&dice);
    const Eigen::Quaterniond R_S = transform.RotationToSlave(R_M);
    const Eigen::Quaterniond negative(-R_M.coeffs());
    EXPECT_LT(transform.RotationToSlave(negative).angularDistance(R_S), 1e-7);
    const Eigen::AngleAxisd turn(dice.Between(-3, 3), any().normalized());
    const Eigen::AngleAxisd turn_S(turn.angle(), transform.R_SM * turn.axis());
    const Eigen::Quaterniond turned = transform.RotationToSlave(turn * R_M);
    EXPECT_LT(turned.angularDistance(turn_S * R_S), 1e-7);
  }
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

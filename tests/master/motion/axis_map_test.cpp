#include "master/motion/axis_map.h"

#include <array>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::HasSubstr;

// All signed permutations.
std::vector<AxisMap> All() {
  std::vector<AxisMap> all;
  for (const auto* order : {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}) {
    for (int signs = 0; signs < 8; ++signs) {
      std::string text;
      for (int i = 0; i < 3; ++i) {
        text += std::string(i > 0 ? "," : "") + ((signs >> i & 1) != 0 ? "-" : "") + order[i];
      }
      all.push_back(AxisMap::Parse(text));
    }
  }
  return all;
}

Eigen::Vector3d NormalVector(std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  return {normal(*random), normal(*random), normal(*random)};
}

TEST(AxisMapTest, NamesTheDeviceAxesForRightUpAndTowardsTheOperator) {
  DeviceReading reading;
  reading.p_M = {1, 2, 3};
  EXPECT_EQ(AxisMap::Parse("-z,x,y").ToMaster(reading).p_M, Eigen::Vector3d(-3, 1, 2));
  EXPECT_EQ(AxisMap::Parse("-z,x,y").ToDevice({-3, 1, 2}), Eigen::Vector3d(1, 2, 3));
}

// Reference: power at the device equals power in M, for forces and torques, also in a mirror. The
// tolerance is rounding.
TEST(AxisMapTest, KeepsThePowerOfForceAndTorque) {
  std::mt19937_64 random(1);
  const auto all = All();
  ASSERT_EQ(all.size(), 48U);
  for (const AxisMap& axes : all) {
    DeviceReading reading;
    reading.p_M = NormalVector(&random);
    reading.v_M = NormalVector(&random);
    reading.w_M = NormalVector(&random);
    const Eigen::Vector3d f_M = NormalVector(&random), t_M = NormalVector(&random);
    const DeviceReading mapped = axes.ToMaster(reading);
    EXPECT_NEAR(f_M.dot(mapped.v_M), axes.ToDevice(f_M).dot(reading.v_M), 1e-14);
    EXPECT_NEAR(t_M.dot(mapped.w_M), axes.TorqueToDevice(t_M).dot(reading.w_M), 1e-14);
    EXPECT_EQ(axes.ToDevice(mapped.p_M), reading.p_M) << "its inverse";
  }
}

// Reference: a point fixed to the handle gives the same result if it is rotated and then mapped, or
// mapped and then rotated.
TEST(AxisMapTest, TurnsWithTheHandle) {
  std::mt19937_64 random(2);
  for (const AxisMap& axes : All()) {
    const Eigen::Vector3d turn = NormalVector(&random), point = NormalVector(&random);
    DeviceReading reading;
    reading.q_M = Eigen::AngleAxisd(turn.norm(), turn.normalized());
    const DeviceReading mapped = axes.ToMaster(reading);
    EXPECT_LT((axes.P() * (reading.q_M * point) - mapped.q_M * (axes.P() * point)).norm(), 1e-14);
    // The rate of a turning handle: v = w x r in both frames.
    reading.w_M = turn;
    const Eigen::Vector3d w_M = axes.ToMaster(reading).w_M;
    EXPECT_LT((axes.P() * turn.cross(point) - w_M.cross(axes.P() * point)).norm(), 1e-14);
  }
}

TEST(AxisMapTest, RejectsWhatIsNoSignedPermutation) {
  for (const char* text :
       {"", "x", "x,y", "x,x,z", "x,y,z,", "x,y,z,x", "x y z", "a,y,z", "--x,y,z", "x,,z", "xyz"}) {
    try {
      (void)AxisMap::Parse(text);
      ADD_FAILURE() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr("expected the device's axes for right, up"));
    }
  }
  EXPECT_THROW(AxisMap{Eigen::Matrix3d::Ones()}, std::invalid_argument);
  EXPECT_THROW(AxisMap{0.5 * Eigen::Matrix3d::Identity()}, std::invalid_argument);
}

}  // namespace
}  // namespace palpate

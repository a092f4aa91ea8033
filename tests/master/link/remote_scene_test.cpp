#include "master/link/remote_scene.h"

#include <cmath>
#include <functional>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpate/v1/scene.pb.h"

#include "tests/support/not_finite.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

v1::SceneDescription GoodScene() {
  v1::SceneDescription scene;
  scene.set_name("block");
  auto* mapping = scene.mutable_operator_();
  mapping->set_position_scale(0.5);
  mapping->set_force_scale(2);
  mapping->set_force_limit(3);
  for (const double q : {std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}) mapping->add_orientation(q);
  scene.mutable_capabilities()->set_simulated(true);
  scene.mutable_capabilities()->set_sensor_rate(60);
  mapping->set_press_depth(0.005);
  mapping->set_press_speed(0.02);
  return scene;
}

TEST(RemoteSceneTest, ReadsTheDescriptionOfTheSlave) {
  const RemoteScene remote = ToRemoteScene(GoodScene());
  EXPECT_EQ(remote.name, "block");
  EXPECT_EQ(remote.transform.position_scale, 0.5);
  EXPECT_EQ(remote.transform.force_scale, 2);
  EXPECT_EQ(remote.force_limit, 3);
  EXPECT_EQ(remote.press_depth, 0.005);
  EXPECT_EQ(remote.press_speed, 0.02);
  EXPECT_EQ(remote.dead_after, 0.030) << "of a slave that says nothing about it";
  EXPECT_TRUE(remote.simulated);
  EXPECT_EQ(remote.sensor_rate, 60);
  // A quarter turn: x of M is y of S.
  EXPECT_TRUE(
      (remote.transform.R_SM * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY(), 1e-15));
  EXPECT_TRUE(remote.transform.offset.isZero(0));
}

// A slave without a scene already has a camera.
TEST(RemoteSceneTest, ASetUpHasTheRateOfItsCamera) {
  v1::SceneDescription scene;
  scene.set_setup_camera("rate: 30 Hz");
  scene.mutable_capabilities()->set_sensor_rate(30);
  const RemoteScene remote = ToRemoteScene(scene);
  EXPECT_TRUE(remote.accepts_setup);
  EXPECT_EQ(remote.sensor_rate, 30);
}

struct Malformation {
  const char* field;
  std::function<void(v1::SceneDescription::Operator*)> apply;
};

class MalformedSceneTest : public testing::TestWithParam<Malformation> {};

TEST_P(MalformedSceneTest, IsRefusedAndNamed) {
  v1::SceneDescription scene = GoodScene();
  GetParam().apply(scene.mutable_operator_());
  EXPECT_THAT(Thrown<std::runtime_error>([&] { ToRemoteScene(scene); }),
              testing::AllOf(testing::HasSubstr(GetParam().field), testing::HasSubstr("expected")));
}

INSTANTIATE_TEST_SUITE_P(
    OneFieldEach, MalformedSceneTest,
    testing::Values(Malformation{"position_scale", [](auto* m) { m->set_position_scale(0); }},
                    Malformation{"force_scale", [](auto* m) { m->set_force_scale(kNan); }},
                    Malformation{"force_limit", [](auto* m) { m->set_force_limit(-1); }},
                    Malformation{"press_speed", [](auto* m) { m->set_press_speed(HUGE_VAL); }},
                    Malformation{"dead_after", [](auto* m) { m->set_dead_after(kNan); }},
                    Malformation{"orientation", [](auto* m) { m->set_orientation(0, 0.1); }}));

}  // namespace
}  // namespace palpate

#include "slave/study/volume_force.h"

#include <cmath>

#include <gtest/gtest.h>

namespace palpate::study {
namespace {

constexpr double kE = 20e3;

// 50 x 44 x 30 mm on a table under a disc of 12 mm that is 0.6 mm deep.
Scene Block(double nu, ContactLaw contact) {
  Scene scene;
  scene.object.geometry = BoxGeometry{{0.05, 0.044, 0.03}, {2, 2, 2}};
  scene.object.material = {kE, nu, 0, 0};
  scene.object.fixed = {{FixedPlane{2, 0}, {true, true, true}}};
  scene.tool = Tool{.width = 0.012};
  scene.model.contact = contact;
  return scene;
}

Press OnTop() {
  return {{0.025, 0.022, 0.03}, -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX()};
}

// Reference: pressed_box.flat of tests/campaigns/truth, whose contact and elements are others. The
// tolerance is that of the documented comparison, and the reference's own 0.5 %.
TEST(VolumeForce, OfAFlatToolOnABoxIsThatOfAnotherFormulation) {
  struct Case {
    double nu;
    ContactLaw contact;
    double force;
  };
  for (const auto& [nu, contact, force] : {Case{0.45, ContactLaw::kBonded, 0.209884},
                                           Case{0.3, ContactLaw::kFrictionless, 0.183641}}) {
    const auto found = VolumeForce(Block(nu, contact), OnTop(), 0.012, 6e-4, kFineGrading);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value / force, 1, 8e-3) << nu;
    EXPECT_LT(std::abs(found->value - force), found->bar) << nu;
  }
}

TEST(VolumeForce, IsNotKnownWhereNothingHoldsTheObject) {
  Scene scene = Block(0.3, ContactLaw::kBonded);
  scene.object.fixed.clear();
  EXPECT_FALSE(VolumeForce(scene, OnTop(), 0.012, 6e-4, kFineGrading));
}

}  // namespace
}  // namespace palpate::study

#include "slave/study/volume_force.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slave/study/reference.h"

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
  scene.model.range = 0.1;
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

// An answer to one press with four-node elements of 5 mm.
StudyRow Answered(const char* kind, FemOptions::Law law, double force) {
  StudyRow row;
  row.kind = row.model.kind = kind;
  row.model.fem.law = law;
  row.linear = law == FemOptions::Law::kLinear;
  row.family = std::string(kind) + (row.linear ? " linear" : " neo-hookean");
  row.element_size = 0.005;
  row.outcome = Outcome::kAnswered;
  const Answer answer{.value = force, .validity = Validity::kValid};
  row.answers = {{answer, answer}};
  return row;
}

// Law: the reference at full depth is the graded solution times what the law adds on equal
// elements of one kind. Other kinds differ by more than the law where elements are coarse.
TEST(VolumeForce, IsRaisedByTheLawOnElementsOfOneKind) {
  using Law = FemOptions::Law;
  const PressSpec question{
      .presses = {OnTop()}, .width = 0.012, .depth = 6e-4, .small_depth = 6e-4, .size = 0.05};
  const ReferenceFinder finder(Block(0.3, ContactLaw::kBonded), question);
  const std::vector<StudyRow> rows{Answered("fem-green", Law::kLinear, 0.12),
                                   Answered("fem", Law::kLinear, 0.2),
                                   Answered("fem", Law::kNeoHookean, 0.202)};
  const Reference reference = finder.Find(rows).presses.front();
  EXPECT_NEAR(reference.full.value / reference.small.value, 1.01, 1e-12);
}

}  // namespace
}  // namespace palpate::study

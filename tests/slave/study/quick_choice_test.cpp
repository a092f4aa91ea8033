#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/study/study.h"
#include "tests/slave/study/fake_model_factory.h"

namespace palpate::study {
namespace {

using testing::HasSubstr;

// Linear elements twice as accurate as constant ones, quadratic ones dear.
fake::World Orders() {
  fake::World world;
  world.stiffness = [](const Scene& scene) {
    const bool constant = scene.model.order == ElementOrder::kConstant;
    return 100 * (1 - (constant ? 6.0 : 3.0) / scene.model.elements);
  };
  world.precompute = [](const Scene& scene) {
    return (scene.model.order == ElementOrder::kQuadratic ? 4e-3 : 1e-3);
  };
  return world;
}

TEST(QuickChoiceTest, TakesTheCheapestThatMeetsToleranceAtTheScenesOwnResolution) {
  fake::World world = Orders();
  Scene scene = fake::Square();
  scene.model.kind = "auto";
  scene.model.tolerance = 0.06;  // 5 % of linear and quadratic elements, not 10 % of constant ones
  const auto choice = ChooseQuickly(scene, world.Make());
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->model.kind, "bem2d");
  EXPECT_EQ(choice->model.order, ElementOrder::kLinear);
  EXPECT_EQ(choice->model.elements, scene.model.elements);
  EXPECT_TRUE(choice->meets);
  EXPECT_THAT(choice->reason, HasSubstr("60 elements"));
  EXPECT_THAT(choice->reason, HasSubstr("5 % error"));
}

TEST(QuickChoiceTest, SaysSoWhereNothingMeetsTheTolerance) {
  fake::World world = Orders();
  Scene scene = fake::Square();
  scene.model.tolerance = 0.01;
  const auto choice = ChooseQuickly(scene, world.Make());
  ASSERT_TRUE(choice);
  EXPECT_FALSE(choice->meets);
  EXPECT_THAT(choice->reason, HasSubstr("none meets tolerance and rate"));
}

TEST(QuickChoiceTest, WithoutAnAnswerInTimeThereIsNoChoice) {
  fake::World world = Orders();
  world.stiffness = [](const Scene&) { return kUnknown; };
  EXPECT_FALSE(ChooseQuickly(fake::Square(), world.Make()));
  world.while_making = [](Progress* progress) {
    progress->Expect({.seconds = 100, .memory_bytes = 0});
    if (!progress->Report("factor", 0)) throw Interrupted();
  };
  EXPECT_FALSE(ChooseQuickly(fake::Square(), world.Make()));
}

TEST(QuickChoiceTest, KeepsToItsBudget) {
  fake::World world = Orders();
  world.precompute = [](const Scene& scene) { return 0.02 * scene.model.elements / 60; };
  const double began = world.clock;
  ChooseQuickly(fake::Square(), world.Make(), 1.5);
  EXPECT_LE(world.clock - began, 2.5);
}

}  // namespace
}  // namespace palpate::study

#include "slave/scene/decided_model.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

Scene BoxScene() {
  Scene scene;
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.06}, {6, 6, 6}};
  return scene;
}

Scene Decided() {
  Scene scene = BoxScene();
  std::get<BoxGeometry>(scene.object.geometry).cells = {9, 9, 12};
  scene.model.kind = "fem";
  scene.model.fem.element = FemOptions::Element::kTet10;
  scene.model.fem.law = FemOptions::Law::kLinear;
  scene.model.fem.residual = 1e-9;
  scene.model.decision = {"auto: fem",
                          true,
                          0.03,
                          {{"fem-green, 6 x 6 x 6 cells", "misses the tolerance", 0.1, 1e-6, 0.2},
                           {"fem tet10", "not tried", kUnknown, kUnknown, kUnknown}}};
  return scene;
}

TEST(DecidedModelTest, ComesBackFromItsTextAsItWas) {
  Scene scene = BoxScene();
  ASSERT_TRUE(ApplyDecided(DecidedText(Decided()), &scene));
  EXPECT_EQ(DecidedText(scene), DecidedText(Decided()));
  EXPECT_EQ(scene.model.kind, "fem");
  EXPECT_EQ(scene.model.fem.element, FemOptions::Element::kTet10);
  EXPECT_THAT(std::get<BoxGeometry>(scene.object.geometry).cells, testing::ElementsAre(9, 9, 12));
  EXPECT_EQ(scene.model.decision.rejected.at(1).why, "not tried");
  EXPECT_TRUE(std::isnan(scene.model.decision.rejected.at(1).error));
}

TEST(DecidedModelTest, DamagedTextAndModelsOfOtherObjectsAreIgnored) {
  const std::string text = DecidedText(Decided());
  const auto with = [&](const std::string& old, const std::string& by) {
    std::string other = text;
    other.replace(other.find(old), old.size(), by);
    return other;
  };
  for (const std::string& bad :
       {std::string(), text.substr(0, text.size() / 2), std::string("[1, 2]"),
        with("\"fem\"", "\"plate\""), with("\"fem\"", "\"auto\""), with("\"fem\"", "7"),
        with("\"elements\": 180", "\"elements\": 100000"), with("\"law\": 1", "\"law\": 9")}) {
    Scene scene = BoxScene();
    EXPECT_FALSE(ApplyDecided(bad, &scene)) << bad;
    EXPECT_EQ(scene.model.kind, "auto");
    EXPECT_THAT(std::get<BoxGeometry>(scene.object.geometry).cells, testing::ElementsAre(6, 6, 6));
  }
}

}  // namespace
}  // namespace palpate

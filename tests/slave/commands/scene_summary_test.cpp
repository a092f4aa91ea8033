#include "slave/commands/scene_summary.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

// Reference: one newton is the weight of 1000 / 9.81 g; a cube of 10 mm at a strain of a tenth
// needs the force E 1e-4 m2 0.1.
TEST(SceneSummaryTest, StateForcesAsWeights) {
  EXPECT_EQ(ForceText(1), "1 N, the weight of 102 g");
  EXPECT_EQ(ForceText(0.27), "0.27 N, the weight of 28 g");
  EXPECT_THAT(ModulusText(127e3), testing::HasSubstr("silicone of Shore 00-50"));
  EXPECT_THAT(ModulusText(127e3), testing::HasSubstr("1.3 N"));
}

// Reference: Gent 1958, On the relation between indentation hardness and Young's modulus.
TEST(SceneSummaryTest, NameARubberByTheHardnessOfItsModulus) {
  for (const int shore : {10, 30, 50, 70, 90}) {
    const double E = 1e6 * 0.0981 * (56 + 7.66 * shore) / (0.137505 * (254 - 2.54 * shore));
    EXPECT_EQ(StiffAs(E), "rubber of Shore A " + std::to_string(shore));
  }
  EXPECT_EQ(StiffAs(1), "brain tissue");
  EXPECT_EQ(StiffAs(1e13), "steel");
}

// Reference: paper A's block needs 2.35 N at 5 mm, and its model is linear: 0.47 N at 1 mm.
TEST(SceneSummaryTest, DescribeTheSiliconeBlock) {
  const Scene scene = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"));
  const std::string words = SceneSummary(scene);
  EXPECT_THAT(words, testing::HasSubstr("rectangle 88 mm x 88 mm, 9 mm thick"));
  EXPECT_THAT(
      words, testing::HasSubstr("silicone of Shore 00-50; 1 mm deep the tool presses with 0.46 N"));
}

}  // namespace
}  // namespace palpate

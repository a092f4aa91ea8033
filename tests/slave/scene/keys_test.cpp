// The table of keys: every row can be read, and its default is accepted.
#include "slave/scene/keys.h"

#include <sstream>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(SceneKeysTest, EveryNumberHasARangeThatItsDefaultMeets) {
  std::istringstream page{std::string(SceneKeysPage())};
  int numbers = 0;
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| `")) continue;
    const std::string path = line.substr(3, line.find('`', 3) - 3);
    const SceneKey& key = SceneKeyAt(path);
    if (line.find("] |") == std::string::npos && line.find("number |") == std::string::npos) {
      continue;
    }
    ++numbers;
    // Their readers have a range for each number of a term, and for each way to track points.
    if (path == "model.terms" || path == "sense.points.count") continue;
    EXPECT_LT(key.rule.least, key.rule.most) << line;
    for (const double value : key.defaults) {
      EXPECT_TRUE((value >= key.rule.least && value <= key.rule.most) || value == 0) << line;
    }
  }
  EXPECT_GT(numbers, 120);
}

TEST(SceneKeysTest, UnitsOfRangesAndDefaultsAreRead) {
  const SceneKey& silence = SceneKeyAt("manipulator.silence");
  EXPECT_EQ(silence.rule.dimension, Dimension::kTime);
  EXPECT_DOUBLE_EQ(silence.rule.least, 0.01);
  EXPECT_DOUBLE_EQ(silence.rule.most, 0.1);
  EXPECT_EQ(silence.defaults, std::vector{0.04});
  const SceneKey& baseline = SceneKeyAt("sense.camera.pair.baseline");
  EXPECT_DOUBLE_EQ(baseline.rule.least, 1e-6);
  EXPECT_DOUBLE_EQ(baseline.rule.most, 1e3);
  EXPECT_EQ(SceneKeyAt("object.pose.translation").defaults.size(), 3U);
  EXPECT_TRUE(SceneKeyAt("object.material.young_modulus").is_required);
}

TEST(SceneKeysTest, ItemsOfListsAndFingersShareOneRow) {
  EXPECT_EQ(&SceneKeyAt("object.regions.3.sphere.radius"),
            &SceneKeyAt("object.regions.sphere.radius"));
  EXPECT_EQ(&SceneKeyAt("sense.tactile.fingers.7.motion"),
            &SceneKeyAt("sense.tactile.fingers.NAME.motion"));
  EXPECT_THROW(SceneKeyAt("object.colour"), std::logic_error);
}

}  // namespace
}  // namespace palpate

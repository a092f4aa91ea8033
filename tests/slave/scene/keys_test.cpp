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
    // Their ranges differ for each number of a term and for each method of tracking points, so they
    // are not compared here.
    if (path == "model.terms" || path == "sense.points.count") continue;
    EXPECT_LT(key.rule.least, key.rule.most) << line;
    for (const double value : key.defaults) {
      EXPECT_TRUE((value >= key.rule.least && value <= key.rule.most) || value == 0) << line;
    }
  }
  EXPECT_GT(numbers, 120);
}

}  // namespace
}  // namespace palpate

#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slave/vision/template_match.h"
#include "tests/support/references.h"

namespace palpate {
namespace {

GreyPatch RandomPatch(int width, int height, int levels, unsigned seed) {
  std::mt19937 random(seed);
  GreyPatch patch;
  patch.Resize(width, height);
  for (auto& level : patch.levels) {
    level = static_cast<std::int16_t>(random() % static_cast<unsigned>(levels));
  }
  return patch;
}

GreyPatch PatchOf(const nlohmann::json& rows) {
  GreyPatch patch;
  patch.Resize(static_cast<int>(rows.at(0).size()), static_cast<int>(rows.size()));
  for (int y = 0; y < patch.height; ++y) {
    for (int x = 0; x < patch.width; ++x) patch.Row(y)[x] = rows.at(y).at(x).get<std::int16_t>();
  }
  return patch;
}

// Eq. (1) as it is written, with means, in double.
double ByDefinition(const GreyPatch& T, const GreyPatch& I, int x, int y) {
  double mean_T = 0, mean_I = 0;
  const double n = T.width * T.height;
  for (int j = 0; j < T.height; ++j) {
    for (int i = 0; i < T.width; ++i) {
      mean_T += T.At(i, j) / n;
      mean_I += I.At(x + i, y + j) / n;
    }
  }
  double TI = 0, TT = 0, II = 0;
  for (int j = 0; j < T.height; ++j) {
    for (int i = 0; i < T.width; ++i) {
      const double t = T.At(i, j) - mean_T, v = I.At(x + i, y + j) - mean_I;
      TI += t * v;
      TT += t * t;
      II += v * v;
    }
  }
  return TI / std::sqrt(TT * II);
}

// Reference: exact integers of the table; 1e-12 is its tolerance in double.
TEST(NccTest, ReproducesTheReferenceTable) {
  PALPATE_CASE_OR_SKIP(reference, "g_vision.json", "ncc_tiny");
  Ncc ncc(PatchOf(reference.at("params").at("template_rows")));
  const ScoreMap& map = ncc.Match(PatchOf(reference.at("params").at("image_rows")));
  const nlohmann::json& rows = reference.at("expected").at("C_rows");
  ASSERT_EQ(static_cast<std::size_t>(map.height), rows.size());
  for (int y = 0; y < map.height; ++y) {
    ASSERT_EQ(static_cast<std::size_t>(map.width), rows.at(y).size());
    for (int x = 0; x < map.width; ++x) {
      const nlohmann::json& expected = rows.at(y).at(x);
      if (expected.is_null()) {
        EXPECT_EQ(map.At(x, y), Ncc::kNoMatch) << x << ", " << y;
      } else {
        EXPECT_NEAR(map.At(x, y), expected.get<double>(), 1e-12) << x << ", " << y;
      }
    }
  }
}

// Reference: the definition in double; 1e-12 for its own rounding. 2048 levels is the most a patch
// holds, and 700 pixels are more products than fit in 32 bits.
TEST(NccTest, AgreesWithTheDefinitionOverTheWholeRangeOfLevels) {
  for (const int levels : {2, 256, 2048}) {
    const GreyPatch pattern = RandomPatch(35, 20, levels, 1),
                    window = RandomPatch(52, 31, levels, 2);
    Ncc ncc(pattern);
    const ScoreMap& map = ncc.Match(window);
    ASSERT_EQ(map.width, 18);
    ASSERT_EQ(map.height, 12);
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        ASSERT_NEAR(map.At(x, y), ByDefinition(pattern, window, x, y), 1e-12) << levels;
      }
    }
  }
}

TEST(NccTest, BrightLevelsDoNotOverflow) {
  GreyPatch pattern;
  pattern.Resize(200, 200);
  for (std::size_t k = 0; k < pattern.levels.size(); ++k) pattern.levels[k] = k % 7 ? 2047 : 2046;
  Ncc ncc(pattern);
  EXPECT_NEAR(ncc.Match(pattern).At(0, 0), 1, 1e-12);
}

// a I + b with a > 0 leaves the score as it is (exactly here: integers); a < 0 turns its sign.
TEST(NccTest, GainAndOffsetOfTheLightDoNotMatter) {
  const GreyPatch pattern = RandomPatch(9, 7, 200, 3), window = RandomPatch(20, 20, 200, 4);
  GreyPatch brighter = window, inverted = window;
  for (auto& level : brighter.levels) level = static_cast<std::int16_t>(3 * level + 40);
  for (auto& level : inverted.levels) level = static_cast<std::int16_t>(200 - level);
  Ncc ncc(pattern);
  const ScoreMap map = ncc.Match(window);
  const ScoreMap map_brighter = ncc.Match(brighter), map_inverted = ncc.Match(inverted);
  for (std::size_t k = 0; k < map.scores.size(); ++k) {
    EXPECT_NEAR(map_brighter.scores[k], map.scores[k], 1e-14);
    EXPECT_NEAR(map_inverted.scores[k], -map.scores[k], 1e-14);
  }
}

TEST(NccTest, ATemplateLargerThanTheWindowMatchesNowhere) {
  Ncc ncc(RandomPatch(9, 7, 200, 3));
  EXPECT_TRUE(ncc.Match(RandomPatch(8, 20, 200, 4)).scores.empty());
  EXPECT_TRUE(ncc.Match(RandomPatch(20, 6, 200, 4)).scores.empty());
  EXPECT_EQ(ncc.Match(RandomPatch(9, 7, 200, 4)).scores.size(), 1U);
}

TEST(NccTest, TemplatesWithoutContrastAreRefused) {
  GreyPatch flat;
  EXPECT_THROW(Ncc{flat}, std::invalid_argument);
  flat.Resize(4, 4);
  EXPECT_THROW(Ncc{flat}, std::invalid_argument);
}

}  // namespace
}  // namespace palpate

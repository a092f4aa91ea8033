#include "slave/vision/ncc.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

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

// Reference: exact integers of the table. Tolerance: scores are of single precision.
constexpr double kSingle = 1e-6;

TEST(NccTest, ReproducesTheReferenceTable) {
  PALPATE_CASE_OR_SKIP(reference, "g_vision.json", "ncc_tiny");
  Ncc ncc(PatchOf(reference.at("params").at("template_rows")));
  const ScoreMap& map = ncc.Match(PatchOf(reference.at("params").at("image_rows")));
  const nlohmann::json& rows = reference.at("expected").at("C_rows");
  ASSERT_EQ(static_cast<std::size_t>(map.rows), rows.size());
  for (int y = 0; y < map.rows; ++y) {
    ASSERT_EQ(static_cast<std::size_t>(map.cols), rows.at(y).size());
    for (int x = 0; x < map.cols; ++x) {
      const nlohmann::json& expected = rows.at(y).at(x);
      if (expected.is_null()) {
        EXPECT_EQ(map(y, x), 0) << x << ", " << y;
      } else {
        EXPECT_NEAR(map(y, x), expected.get<double>(), kSingle) << x << ", " << y;
      }
    }
  }
}

// Reference: the definition in double. 2048 levels is the most a patch holds.
TEST(NccTest, AgreesWithTheDefinitionOverTheWholeRangeOfLevels) {
  for (const int levels : {2, 256, 2048}) {
    const GreyPatch pattern = RandomPatch(35, 20, levels, 1),
                    window = RandomPatch(52, 31, levels, 2);
    Ncc ncc(pattern);
    const ScoreMap& map = ncc.Match(window);
    ASSERT_EQ(map.cols, 18);
    ASSERT_EQ(map.rows, 12);
    for (int y = 0; y < map.rows; ++y) {
      for (int x = 0; x < map.cols; ++x) {
        const double expected = ByDefinition(pattern, window, x, y);
        ASSERT_NEAR(map(y, x), expected, kSingle) << levels;
        ASSERT_NEAR(ncc.At(window, x, y), expected, 1e-12) << levels;
      }
    }
  }
}

}  // namespace
}  // namespace palpate

#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/study/study.h"

namespace palpate::study {
namespace {

StudyRow Answered(double error, double update_s, double precompute_s = 0.01) {
  StudyRow row;
  row.family = "model";
  row.outcome = Outcome::kAnswered;
  row.error = {error, 0};
  row.update_median_s = update_s;
  row.update_p99_s = 2 * update_s;
  row.precompute_s = precompute_s;
  return row;
}

std::vector<int> Marked(const std::vector<StudyRow>& rows, bool StudyRow::*flag) {
  std::vector<int> marked;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].*flag) marked.push_back(static_cast<int>(i));
  }
  return marked;
}

TEST(ParetoTest, FrontHoldsWhatNothingBeats) {
  std::vector<StudyRow> rows{Answered(0.1, 1), Answered(0.05, 2), Answered(0.06, 3),
                             Answered(0.1, 0.5), Answered(0.01, 9)};
  MarkFront(&rows);
  EXPECT_THAT(Marked(rows, &StudyRow::on_front), testing::ElementsAre(1, 3, 4));
}

// Reference: the definition, by trying every pair in a second way (sorted sweep).
TEST(ParetoTest, FrontOfRandomRowsIsTheLowerStaircase) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> uniform(1, 12);  // ties are common
  for (int round = 0; round < 200; ++round) {
    std::vector<StudyRow> rows;
    for (int i = 0; i < 15; ++i) rows.push_back(Answered(uniform(random), uniform(random)));
    MarkFront(&rows);
    for (const StudyRow& row : rows) {
      double least_faster = 1e9;  // smallest error among the faster, or as fast
      for (const StudyRow& other : rows) {
        if (other.update_median_s < row.update_median_s) {
          least_faster = std::min(least_faster, other.error.value);
        }
      }
      double least_equal = 1e9;
      for (const StudyRow& other : rows) {
        if (other.update_median_s == row.update_median_s) {
          least_equal = std::min(least_equal, other.error.value);
        }
      }
      const bool expected = row.error.value < least_faster && row.error.value == least_equal;
      EXPECT_EQ(row.on_front, expected);
    }
  }
}

TEST(ParetoTest, RowsWithoutAnErrorAreNeverOnTheFrontNorRecommended) {
  std::vector<StudyRow> rows{Answered(0.1, 1e-3), Answered(kUnknown, 1e-6),
                             Answered(0.01, kUnknown)};
  rows.push_back(Answered(0.001, 1e-6));
  rows.back().outcome = Outcome::kFailed;
  MarkFront(&rows);
  Recommend(0.05, 10, &rows);
  EXPECT_THAT(Marked(rows, &StudyRow::on_front), testing::ElementsAre(0));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(0));
}

TEST(ParetoTest, RecommendsTheCheapestThatMeetsBoth) {
  // As fast as makes no difference: then precompute decides.
  std::vector<StudyRow> rows{Answered(0.2, 1e-6, 0.001), Answered(0.04, 1.1e-6, 0.5),
                             Answered(0.03, 1.0e-6, 4), Answered(0.001, 5e-6, 0.01),
                             Answered(0.04, 1, 0.001)};
  const std::string why = Recommend(0.05, 500, &rows);
  EXPECT_THAT(Marked(rows, &StudyRow::meets_tolerance), testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(Marked(rows, &StudyRow::meets_rate), testing::ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(1));
  EXPECT_THAT(why, testing::HasSubstr("cheapest that meets tolerance and rate"));
}

TEST(ParetoTest, RateHoldsForTheSlowestPercent) {
  std::vector<StudyRow> rows{Answered(0.01, 0.9e-3)};  // p99 1.8 ms
  Recommend(0.05, 1000, &rows);
  EXPECT_FALSE(rows[0].meets_rate);
  Recommend(0.05, 500, &rows);
  EXPECT_TRUE(rows[0].meets_rate);
}

TEST(ParetoTest, NearestToWhatIsAskedForWhereNothingMeetsBoth) {
  // Error over tolerance, and p99 times rate: 4 and 0.001; 2 and 0.001; 0.2 and 3.
  std::vector<StudyRow> rows{Answered(0.2, 1e-6), Answered(0.1, 1e-6), Answered(0.01, 3e-3)};
  EXPECT_THAT(Recommend(0.05, 500, &rows), testing::HasSubstr("no model meets tolerance and rate"));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(1));
  rows.erase(rows.begin() + 1);
  Recommend(0.05, 500, &rows);
  EXPECT_TRUE(rows[1].recommended) << "three times too slow beats four times too wrong";
  rows.clear();
  EXPECT_THAT(Recommend(0.05, 500, &rows), testing::HasSubstr("no model has a known error"));
}

}  // namespace
}  // namespace palpate::study

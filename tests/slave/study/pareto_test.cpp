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

// Reference: the definition, implemented by comparing every pair.
TEST(ParetoTest, FrontOfRandomRowsIsTheLowerStaircase) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> uniform(1, 12);  // ties are common
  for (int round = 0; round < 200; ++round) {
    std::vector<StudyRow> rows;
    for (int i = 0; i < 15; ++i) rows.push_back(Answered(uniform(random), uniform(random)));
    MarkFront(&rows);
    for (const StudyRow& row : rows) {
      double faster = 1e9, as_fast = 1e9;  // smallest errors among those
      for (const StudyRow& other : rows) {
        const double update = other.update_median_s, error = other.error.value;
        if (update < row.update_median_s) faster = std::min(faster, error);
        if (update == row.update_median_s) as_fast = std::min(as_fast, error);
      }
      EXPECT_EQ(row.on_front, row.error.value < faster && row.error.value == as_fast);
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

// The rate may be met even if the error is unknown.
TEST(ParetoTest, RateIsMetWithoutAKnownError) {
  std::vector<StudyRow> rows{Answered(kUnknown, 1e-6), Answered(0.2, 1)};
  Recommend(0.05, 500, &rows);
  EXPECT_THAT(Marked(rows, &StudyRow::meets_rate), testing::ElementsAre(0));
  EXPECT_THAT(Marked(rows, &StudyRow::meets_tolerance), testing::ElementsAre());
}

TEST(ParetoTest, RecommendsTheCheapestThatMeetsBoth) {
  // The update times are practically equal, so the preparation time decides.
  std::vector<StudyRow> rows{Answered(0.2, 1e-6, 0.001), Answered(0.04, 1.1e-6, 0.5),
                             Answered(0.03, 1.0e-6, 4), Answered(0.001, 5e-6, 0.01),
                             Answered(0.04, 1, 0.001)};
  const std::string why = Recommend(0.05, 500, &rows);
  EXPECT_THAT(Marked(rows, &StudyRow::meets_tolerance), testing::ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(Marked(rows, &StudyRow::meets_rate), testing::ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(1));
  EXPECT_THAT(why, testing::HasSubstr("cheapest that meets tolerance and rate"));
}

TEST(ParetoTest, ChoosesTheNearestModelIfNoneMeetsBoth) {
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

StudyRow Beyond(StudyRow row, std::size_t beyond) {
  row.answers.resize(20);
  row.beyond = beyond;
  row.validity = beyond > 0 ? Validity::kExtrapolated : Validity::kValid;
  row.reason = beyond > 0 ? "too coarse" : "";
  return row;
}

// A model that is in its range everywhere is taken before one that is cheaper, more accurate or
// both, even if it misses the requested tolerance.
TEST(ParetoTest, ModelsBeyondTheirRangeAreTheLastChoice) {
  std::vector<StudyRow> rows{Beyond(Answered(0.01, 1e-6, 0.001), 20),
                             Beyond(Answered(0.04, 2e-5), 0)};
  EXPECT_THAT(Recommend(0.05, 500, &rows), testing::Not(testing::HasSubstr("range")));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(1));
  rows[1].error.value = 0.06;
  EXPECT_THAT(Recommend(0.05, 500, &rows), testing::HasSubstr("no model meets"));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(1));

  rows[1] = Beyond(rows[1], 2);
  EXPECT_THAT(Recommend(0.05, 500, &rows), testing::HasSubstr("is at 18 of 20: too coarse"));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(1)) << "nine of ten";
  rows[1] = Beyond(rows[1], 3);
  EXPECT_THAT(Recommend(0.05, 500, &rows), testing::HasSubstr("this one is at 0 of 20"));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(0));
}

// The percentile of some contacts may be within the tolerance and that of all places is not.
TEST(ParetoTest, ToleranceIsMetWhereTheBoundMeetsIt) {
  std::vector<StudyRow> rows{Answered(0.04, 1e-6), Answered(0.045, 2e-6)};
  rows[0].bound = 0.06;
  rows[1].bound = 0.05;
  Recommend(0.05, 500, &rows);
  EXPECT_THAT(Marked(rows, &StudyRow::meets_tolerance), testing::ElementsAre(1));
  EXPECT_THAT(Marked(rows, &StudyRow::recommended), testing::ElementsAre(1));
}

// Reference: the published sizes of samples of which the largest, the second largest and so on are
// 95 % bounds of the 90th percentile (tables of Wilks' tolerance limits).
TEST(ParetoTest, BoundOfNineOfTenHasThePublishedRanks) {
  const std::vector<std::size_t> sizes{29, 46, 61, 76, 89, 103};
  for (std::size_t rank = 0; rank < sizes.size(); ++rank) {
    EXPECT_EQ(BeyondBound(sizes[rank]), rank) << sizes[rank];
    EXPECT_EQ(BeyondBound(sizes[rank] - 1), rank > 0 ? rank - 1 : 0) << sizes[rank];
  }
  EXPECT_EQ(BeyondBound(1), 0U);
}

}  // namespace
}  // namespace palpate::study
